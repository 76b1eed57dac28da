// SPDX-License-Identifier: MIT
#include "bench/does_it_help/frame_noise.hpp"

#include "bench/world/projection.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace maxlogdet::sim {
namespace {

struct WhitenedResidual {
  std::uint32_t cell;
  int rows;
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 6> H;
  double leverage;
};

std::vector<WhitenedResidual> residuals_of(const Frame& frame, const PoseEstimate& all, const Matrix6& covariance,
                                           const std::vector<std::uint32_t>& which,
                                           const std::vector<Whitening>& whitenings) {
  std::vector<WhitenedResidual> residuals;
  const bool uses_depth_cue = frame.camera.depth_cue() != DepthCue::none;
  for (const std::uint32_t i : which) {
    const Match& match = frame.matches[i];
    LinearizedMatch at;
    if (!linearize(frame.camera, all.T_cw, match, uses_depth_cue, at)) continue;
    WhitenedResidual one;
    const auto cell = noise_grid.cell_of(frame, match);
    one.cell = cell + static_cast<std::uint32_t>(noise_grid.cells()) * match.camera_id;
    one.rows = at.rows;
    const Eigen::Matrix3d W = whitenings[i].matrix();
    one.r = W * at.residual;
    one.H = W * at.H_x;
    one.leverage = (one.H * covariance * one.H.transpose()).trace();
    if (one.r.allFinite() && one.H.allFinite()) residuals.push_back(one);
  }
  return residuals;
}

PairSums pair_sums(std::vector<WhitenedResidual> residuals, const Matrix6& covariance) {
  std::stable_sort(residuals.begin(), residuals.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
  PairSums sums;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const Eigen::Vector2d r = residuals[i].r.head<2>();
    const Eigen::Matrix<double, 2, 6> HC = residuals[i].H.topRows<2>() * covariance;
    sums.squares += r.squaredNorm();
    sums.fitted_self += HC.cwiseProduct(residuals[i].H.topRows<2>()).sum();
    ++sums.matches;
    for (std::size_t j = i + 1; j < residuals.size() && residuals[j].cell == residuals[i].cell; ++j) {
      sums.products += r.dot(residuals[j].r.head<2>());
      sums.fitted += HC.cwiseProduct(residuals[j].H.topRows<2>()).sum();
      ++sums.pairs;
    }
  }
  return sums;
}

}  // namespace

FrameNoise noise_of(const Frame& frame, const PoseEstimate& all, const std::vector<std::uint32_t>& inliers,
                    const std::vector<Whitening>& whitenings) {
  const Matrix6 covariance = all.covariance();
  std::vector<WhitenedResidual> residuals = residuals_of(frame, all, covariance, inliers, whitenings);
  FrameNoise noise;
  noise.pairs = pair_sums(residuals, covariance);
  std::stable_sort(residuals.begin(), residuals.end(),
                   [](const auto& a, const auto& b) { return a.leverage < b.leverage; });
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const std::size_t decile = leverage_classes * i / residuals.size();
    noise.chi2[decile] += residuals[i].r.squaredNorm();
    noise.freedom[decile] += residuals[i].rows - residuals[i].leverage;
  }
  return noise;
}

// E[r_i . r_j] = s^2 (2 rho - tr(H_i C H_j^T)), E[r_i . r_i] = s^2 (2 - tr(H_i C H_i^T)) where neighbours are
// correlated by rho and noise is s times as large as modelled.
double correlation_of(const PairSums& sums) {
  const double per_variance = 2 * sums.matches - sums.fitted_self;
  if (!(sums.pairs > 0) || !(per_variance > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double variance = sums.squares / per_variance;
  return (sums.products / variance + sums.fitted) / (2 * sums.pairs);
}

PairSums operator+(const PairSums& a, const PairSums& b) {
  return {a.products + b.products, a.fitted + b.fitted,           a.pairs + b.pairs,
          a.squares + b.squares,   a.fitted_self + b.fitted_self, a.matches + b.matches};
}

PairSums operator*(double factor, const PairSums& sums) {
  return {factor * sums.products, factor * sums.fitted,      factor * sums.pairs,
          factor * sums.squares,  factor * sums.fitted_self, factor * sums.matches};
}

}  // namespace maxlogdet::sim
