// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/draws.hpp"
#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace maxlogdet::sim {

/// State of the constant-velocity camera: error of the pose (left perturbation), error of the velocity per frame.
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// Selection by observability (Zhang & Vela 2015). The motion is taken as piecewise linear, one segment between two
/// frames; over a segment with velocity v,
///
///   F = [ Ad(exp(v^))  J_l(v) ]      H = [ H_x  0 ]      rows of a match: H; H F,
///       [     0           I   ]
///
/// and the observability matrix of a set of matches stacks these rows for all its matches and the last segments. Higher
/// powers of F add only terms of the order of v. H_x of both rows is that of the segment's end, and segments are
/// stacked without transitions between them (the stripped observability matrix). Greedy maximises the smallest singular
/// value of that matrix among random samples of candidates, as Algorithm 1 does with log det.
class ObservabilitySelection {
 public:
  explicit ObservabilitySelection(std::size_t segments = 3) : segments_(segments) {}

  void add_pose(const Pose& T_cw);

  /// Returns O_i^T O_i of each candidate, O_i its rows over the poses added and frame.T_cw_prior.
  std::vector<Matrix12> information(const Frame& frame, const std::vector<std::uint32_t>& candidates) const;

  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& candidates, std::size_t k,
                                    double epsilon, Draws& draws) const;

 private:
  std::size_t segments_;
  std::deque<Pose> poses_;  // the last `segments_`, oldest first
};

}  // namespace maxlogdet::sim
