// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/mapped_world.hpp"
#include "bench/does_the_paper_hold/observability.hpp"
#include "bench/does_the_paper_hold/trajectory.hpp"
#include "bench/world/feature_selector.hpp"
#include "bench/world/table.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Wall times, ms: outlier rejection; selection, building its blocks included; pose optimisation.
using StepTimes = Eigen::Array3d;

/// The result of one frame.
struct TrackedFrame {
  Pose T_cw = Pose::Identity();         ///< optimised; where that failed, predicted
  bool is_tracked = false;              ///< whether the pose comes from matches
  std::vector<std::uint32_t> selected;  ///< what the pose was optimised with
  StepTimes ms = StepTimes::Zero();
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

/// The outcome of one selector in one run. All but `lost` and the errors are means of a frame.
struct TrackingOutcome {
  TrajectoryErrors errors;
  StepTimes ms = StepTimes::Zero();
  double matches = 0;    ///< before outlier rejection
  double used = 0;       ///< what the pose was optimised with
  std::size_t lost = 0;  ///< frames without a pose from matches
};

/// A selector as in section V of the paper, which searches the blocks H_c exactly.
SelectorSettings paper_selector(SelectorKind kind, std::size_t budget = 100);

/// Computes a run along a trajectory, with every selector on the same frames: deterministic in the seed, trajectory
/// name and run, except times. Returns an outcome for each selector.
std::vector<TrackingOutcome> run_tracking(const WorldOptions& world, const std::vector<SelectorSettings>& selectors,
                                          const Trajectory& trajectory, std::uint64_t seed, std::uint64_t run);

/// Finished runs along trajectories.
struct TrackingRuns {
  std::vector<std::string> selectors;
  std::vector<std::string> sequences;
  std::vector<std::vector<std::vector<TrackingOutcome>>> outcomes;  ///< by sequence, run and selector
};

/// Tables II and III of the paper: errors by sequence and selector, means over runs.
Table sequences_table(const TrackingRuns& runs);

/// The rows below table II: by selector the errors, means over sequences with the 95 % interval over runs; and for RPE
/// and ROE the numbers of sequences that are worse and better than with `all`, and the mean differences there.
Table means_table(const TrackingRuns& runs);

/// The difference of each of `ours` to each of `theirs` in percent of the other's error, mean over sequences, with its
/// 95 % interval over runs (paired: both see the same frames), and the verdict on ours.
Table differences_table(const TrackingRuns& runs, const std::vector<std::string>& ours,
                        const std::vector<std::string>& theirs);

/// Table IV: mean times of a frame (ms), and how many matches the pose was optimised with.
Table times_table(const TrackingRuns& runs);

}  // namespace maxlogdet::sim
