// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/observability.hpp"

#include "bench/world/projection.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet::sim {
namespace {

// Bounds the error of an eigenvalue of Q, relative to its trace; the solver's is about 1e-15.
constexpr double eigenvalue_rounding = 1e-13;

double smallest_eigenvalue(const Matrix12& Q) {
  return Eigen::SelfAdjointEigenSolver<Matrix12>(Q, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

bool exceeds(const Matrix12& Q, double eigenvalue) {
  const Matrix12 shifted = Q - eigenvalue * Matrix12::Identity();
  return Eigen::LLT<Matrix12>(shifted).info() == Eigen::Success;
}

// F's upper half by the series of its generator: J_l = sum ad^n / (n + 1)!, and Ad = I + ad J_l.
Eigen::Matrix<double, 6, 12> powers_of_motion(const Vector6& v) {
  Matrix6 ad = Matrix6::Zero();
  ad.topLeftCorner<3, 3>() = ad.bottomRightCorner<3, 3>() = skew(v.tail<3>());
  ad.topRightCorner<3, 3>() = skew(v.head<3>());
  Matrix6 term = Matrix6::Identity(), J = term;
  for (int n = 2; !term.isZero(1e-18); ++n) J += term = (term * ad / n).eval();
  Eigen::Matrix<double, 6, 12> powers;
  powers << Matrix6::Identity() + ad * J, J;
  return powers;
}

}  // namespace

void ObservabilitySelection::add_pose(const Pose& T_cw) {
  poses_.push_back(T_cw);
  if (poses_.size() > segments_) poses_.pop_front();
}

std::vector<Matrix12> ObservabilitySelection::information(const Frame& frame,
                                                          const std::vector<std::uint32_t>& candidates) const {
  std::vector<Matrix12> sums(candidates.size(), Matrix12::Zero());
  Pose end = pose_of(frame.T_cw_prior);
  for (std::size_t back = 0; back < std::max<std::size_t>(poses_.size(), 1); ++back) {
    const Pose begin = poses_.empty() ? end : poses_[poses_.size() - 1 - back];
    const Eigen::Matrix<double, 6, 12> powers = powers_of_motion(log_se3(end * begin.inverse()));
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      LinearizedMatch at_end;
      if (!linearize(frame.camera, end, frame.matches[candidates[c]], false, at_end)) continue;
      const Eigen::Matrix<double, 2, 6> H_x = at_end.H_x().topRows<2>();
      const Eigen::Matrix<double, 2, 12> H_F = H_x * powers;
      sums[c].topLeftCorner<6, 6>().noalias() += H_x.transpose() * H_x;
      sums[c].noalias() += H_F.transpose() * H_F;
    }
    end = begin;
  }
  return sums;
}

std::vector<std::uint32_t> ObservabilitySelection::select(const Frame& frame,
                                                          const std::vector<std::uint32_t>& candidates, std::size_t k,
                                                          double epsilon, Draws& draws) const {
  const std::vector<Matrix12> information_of = information(frame, candidates);
  std::vector<std::uint32_t> remaining(candidates.size());
  std::iota(remaining.begin(), remaining.end(), 0U);
  k = std::min(k, candidates.size());
  const double share = static_cast<double>(candidates.size()) / static_cast<double>(std::max<std::size_t>(k, 1));
  const auto sample = static_cast<std::size_t>(std::ceil(share * std::log(1 / epsilon)));
  std::vector<std::uint32_t> selected;
  Matrix12 Q = Matrix12::Zero();
  while (selected.size() < k) {
    const std::size_t looked_at = std::min(sample, remaining.size());
    draws.shuffle_front(remaining, looked_at);
    std::size_t winner = 0;
    double best = smallest_eigenvalue(Q + information_of[remaining[0]]);
    for (std::size_t r = 1; r < looked_at; ++r) {
      const Matrix12 with_it = Q + information_of[remaining[r]];
      const double rounding = eigenvalue_rounding * with_it.trace();
      if (!exceeds(with_it, best - rounding)) continue;  // far faster than a decomposition
      const double value = smallest_eigenvalue(with_it);
      if (!(value > best + rounding)) continue;  // ties go to the first
      winner = r;
      best = value;
    }
    selected.push_back(candidates[remaining[winner]]);
    Q += information_of[remaining[winner]];
    std::swap(remaining[winner], remaining.back());
    remaining.pop_back();
  }
  return selected;
}

}  // namespace maxlogdet::sim
