// SPDX-License-Identifier: MIT
#include "bench/world/shared_error.hpp"

#include "bench/world/match_noise.hpp"
#include "bench/world/projection.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Rounding lets a gain exceed its bound by at most this, nats.
constexpr double rounding = 1e-9;

// Sigma_p as a block of these options has it, m^2.
Eigen::Matrix3d map_covariance_of(const BlockOptions& options, const double* known) {
  if (options.weighting != Weighting::measurement_and_map) return Eigen::Matrix3d::Zero();
  if (known != nullptr) return Eigen::Map<const Eigen::Matrix3d>(known);
  return options.map_sigma * options.map_sigma * Eigen::Matrix3d::Identity();
}

// G and S of SharedInformation.
struct NextBlock {
  Eigen::Matrix<double, 3, 6> G;
  Eigen::Matrix3d S;
};

template <class Group>
NextBlock next_block(const WhitenedMatch& match, const Group& group) {
  return {match.H - match.N * group.Q, Eigen::Matrix3d::Identity() + match.N * group.P * match.N.transpose()};
}

// The determinant of a positive definite matrix of which only the lower triangle is read.
double determinant(const Eigen::Matrix3d& A) {
  const double d0 = A(0, 0);
  const double l10 = A(1, 0) / d0, l20 = A(2, 0) / d0;
  const double d1 = A(1, 1) - l10 * A(1, 0);
  const double c21 = A(2, 1) - l20 * A(1, 0);
  const double d2 = A(2, 2) - l20 * A(2, 0) - c21 * c21 / d1;
  return d0 * d1 * d2;
}

}  // namespace

WhitenedMatch whiten(const Frame& frame, std::size_t i, const BlockOptions& options, const double* map_covariance) {
  WhitenedMatch result;
  const Match& match = frame.matches[i];
  const bool stereo = options.depth_cue == DepthCue::stereo;
  const Pose T_cw = pose_of(frame.T_cw_prior);
  LinearizedMatch at;
  if (!(in_camera(frame, match)[2] >= options.min_depth) || !linearize(frame.camera, T_cw, match, stereo, at)) {
    return result;
  }
  const Eigen::Matrix3d whitening =
      whitening_of(frame.camera, T_cw, match, stereo, map_covariance_of(options, map_covariance)).matrix();
  Eigen::Matrix<double, 3, 2> of_group;
  of_group << 1, 0, 0, 1, at.rows == 3 ? 1 : 0, 0;
  result.H = whitening * at.H_x;
  result.N = whitening * of_group;
  if (result.H.allFinite() && result.N.allFinite()) result.rows = at.rows;
  return result;
}

void SharedInformation::reset(std::size_t groups, double tau, const Matrix6& prior) {
  groups_.assign(groups, {tau * tau * Eigen::Matrix2d::Identity(), Eigen::Matrix<double, 2, 6>::Zero()});
  factor_ = Eigen::LLT<Matrix6>(prior).matrixU();
  inverse_factor_ = factor_.triangularView<Eigen::Upper>().solve(Matrix6::Identity());
}

// Matrix determinant lemma: det(M + G^T S^-1 G) / det M = det(S + G M^-1 G^T) / det S.
double SharedInformation::gain(const WhitenedMatch& match, std::size_t group) const {
  const NextBlock block = next_block(match, groups_[group]);
  const Eigen::Matrix<double, 3, 6> V = block.G * inverse_factor_;
  return std::log(determinant(block.S + V * V.transpose()) / determinant(block.S));
}

// The rows S^-1/2 G below R, turned upper triangular again: M itself, whose condition is R's squared, is never formed.
void SharedInformation::add(const WhitenedMatch& match, std::size_t group) {
  Group& state = groups_[group];
  const NextBlock block = next_block(match, state);
  const Eigen::LLT<Eigen::Matrix3d> factor(block.S);
  Eigen::Matrix<double, 9, 6> stacked;
  stacked << factor_, factor.matrixL().solve(block.G);
  factor_ =
      Eigen::HouseholderQR<Eigen::Matrix<double, 9, 6>>(stacked).matrixQR().topRows<6>().triangularView<Eigen::Upper>();
  inverse_factor_ = factor_.triangularView<Eigen::Upper>().solve(Matrix6::Identity());

  const Eigen::Matrix<double, 2, 3> kalman_gain = factor.solve(match.N * state.P).transpose();
  state.Q += kalman_gain * block.G;
  state.P -= kalman_gain * match.N * state.P;
}

void SharedErrorSelection::select(const std::vector<WhitenedMatch>& matches, const std::vector<std::uint32_t>& groups,
                                  std::size_t group_count, double tau, const Matrix6& prior, std::size_t budget,
                                  std::vector<std::uint32_t>& selected) {
  information_.reset(group_count, tau, prior);
  selected.clear();
  evaluations_ = 0;
  remaining_.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    if (matches[i].rows > 0) remaining_.push_back({i, infinity});
  }
  while (selected.size() < budget && !remaining_.empty()) {
    const std::size_t best = best_of_round(matches, groups);
    const std::uint32_t i = remaining_[best].match;
    selected.push_back(i);
    information_.add(matches[i], groups[i]);
    remaining_.erase(remaining_.begin() + static_cast<std::ptrdiff_t>(best));
    for (Candidate& other : remaining_) {
      if (groups[other.match] == groups[i]) other.bound = infinity;
    }
  }
}

// Evaluates the candidate with the largest bound first, so that most others need no evaluation.
std::size_t SharedErrorSelection::best_of_round(const std::vector<WhitenedMatch>& matches,
                                                const std::vector<std::uint32_t>& groups) {
  const auto evaluate = [&](Candidate& candidate) {
    ++evaluations_;
    return candidate.bound = information_.gain(matches[candidate.match], groups[candidate.match]);
  };
  const auto leader = std::max_element(remaining_.begin(), remaining_.end(),
                                       [](const Candidate& a, const Candidate& b) { return a.bound < b.bound; });
  auto best = static_cast<std::size_t>(leader - remaining_.begin());
  double highest = evaluate(*leader);
  for (std::size_t c = 0; c < remaining_.size(); ++c) {
    if (remaining_[c].bound + rounding < highest || c == best) continue;
    const double gain = evaluate(remaining_[c]);
    if (gain > highest || (gain == highest && c < best)) {
      highest = gain;
      best = c;
    }
  }
  return best;
}

}  // namespace maxlogdet::sim
