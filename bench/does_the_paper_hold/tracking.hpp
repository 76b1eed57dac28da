// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/mapped_world.hpp"
#include "bench/does_the_paper_hold/observability.hpp"
#include "bench/does_the_paper_hold/trajectory_error.hpp"
#include "bench/world/feature_selector.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// The result of one frame.
struct TrackedFrame {
  Pose T_cw = Pose::Identity();         ///< optimised; where that failed, predicted
  bool is_tracked = false;              ///< whether the pose comes from matches
  std::vector<std::uint32_t> selected;  ///< what the pose was optimised with
  double ms_outliers = 0;               ///< wall time: outlier rejection
  double ms_selection = 0;              ///< selection, building its blocks included
  double ms_pose = 0;                   ///< pose optimisation
};

/// Tracks frames as in section V: constant-velocity prediction; outlier rejection by optimising the pose with all
/// matches; selection among the inliers, linearised at that pose; pose optimisation with the selected ones.
class PoseTracker {
 public:
  /// Begins at a known pose.
  PoseTracker(const SelectorSettings& selection, const Pose& T_cw);

  /// Predicts the next pose by the constant velocity of the last two frames.
  Pose predict() const;

  /// Tracks the next frame; frame.T_cw_prior is overwritten.
  TrackedFrame track(Frame& frame);

  /// With fewer inliers a pose is not trusted.
  static constexpr std::size_t min_inliers = 10;

 private:
  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& inliers);

  FeatureSelector selector_;              // of every kind but observability
  ObservabilitySelection observability_;  // of this kind
  Draws draws_;                           // its
  Pose last_;
  Pose velocity_ = Pose::Identity();  // T_cw of the last frame = velocity * T_cw of the one before
};

/// The outcome of one selector in one run.
struct TrackingOutcome {
  TrajectoryErrors errors;
  double ms_outliers = 0;  ///< mean of a frame
  double ms_selection = 0;
  double ms_pose = 0;
  double matches = 0;    ///< mean of a frame, before outlier rejection
  double used = 0;       ///< mean of a frame: what the pose was optimised with
  std::size_t lost = 0;  ///< frames without a pose from matches
};

/// A selector as in section V of the paper, which searches the blocks H_c exactly.
SelectorSettings paper_selector(SelectorKind kind, std::size_t budget = 100);

/// Computes a run along a trajectory, with every selector on the same frames: deterministic in the seed, trajectory
/// name and run, except times. Returns an outcome for each selector.
std::vector<TrackingOutcome> run_tracking(const WorldOptions& world, const std::vector<SelectorSettings>& selectors,
                                          const Trajectory& trajectory, std::uint64_t seed, std::uint64_t run);

}  // namespace maxlogdet::sim
