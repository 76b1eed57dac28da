// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/mapped_world.hpp"
#include "bench/does_the_paper_hold/pose_tracker.hpp"
#include "bench/does_the_paper_hold/trajectory.hpp"
#include "bench/does_the_paper_hold/trajectory_error.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Section V of the paper: a camera is tracked along a trajectory in a mapped world, with every selector on the same
/// frames.
struct TrackingOptions {
  WorldOptions world;
  RejectionOptions optimization;
  std::vector<SelectorSettings> selectors;
  double window = 3;  ///< s, of RPE and ROE
  std::uint64_t seed = 0;
};

nlohmann::ordered_json to_json(const WorldOptions& options);

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

/// Computes a run along a trajectory: deterministic in options, trajectory name and run, except times. Returns an
/// outcome for each selector.
std::vector<TrackingOutcome> run_tracking(const TrackingOptions& options, const Trajectory& trajectory, const Rig& rig,
                                          std::uint64_t run);

}  // namespace maxlogdet::sim
