// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking.hpp"

#include "bench/world/hash.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <chrono>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

class Stopwatch {
 public:
  // Returns the time since the last lap, ms.
  double lap() {
    const auto now = Clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

Rejection optimize(const Frame& frame, const std::vector<std::uint32_t>& subset, const Pose& start) {
  RejectionOptions options;
  options.step_tolerance = 1e-6;
  return reject_outliers(frame.camera, frame.matches, subset, start, options);
}

bool is_good(const Rejection& optimized) {
  return optimized.estimate.is_usable() && optimized.inliers.size() >= PoseTracker::min_inliers;
}

}  // namespace

PoseTracker::PoseTracker(const SelectorSettings& selection, const Pose& T_cw)
    : selector_(selection), draws_(selection.seed), last_(T_cw) {
  observability_.add_pose(T_cw);
}

std::vector<std::uint32_t> PoseTracker::select(const Frame& frame, const std::vector<std::uint32_t>& inliers) {
  const SelectorSettings& settings = selector_.settings();
  if (settings.kind != SelectorKind::observability) return selector_.select(frame, inliers);
  if (inliers.size() <= settings.budget) return inliers;
  return observability_.select(frame, inliers, settings.budget, settings.epsilon, draws_);
}

Pose PoseTracker::predict() const { return orthonormal(velocity_ * last_); }

TrackedFrame PoseTracker::track(Frame& frame) {
  TrackedFrame result;
  result.T_cw = predict();
  frame.T_cw_prior = to_rows(result.T_cw);
  result.selected.resize(frame.matches.size());
  std::iota(result.selected.begin(), result.selected.end(), 0U);

  Stopwatch watch;
  Pose start = result.T_cw;
  if (rejects_outliers(selector_.settings().kind)) {
    const Rejection all = optimize(frame, result.selected, start);
    if (is_good(all)) start = all.estimate.T_cw;
    frame.T_cw_prior = to_rows(start);
    result.ms_outliers = watch.lap();
    result.selected = select(frame, all.inliers);
    result.ms_selection = watch.lap();
  }
  const Rejection optimized = optimize(frame, result.selected, start);
  result.ms_pose = watch.lap();

  result.is_tracked = is_good(optimized);
  if (result.is_tracked) result.T_cw = optimized.estimate.T_cw;
  velocity_ = result.T_cw * last_.inverse();
  last_ = result.T_cw;
  observability_.add_pose(result.T_cw);
  return result;
}

SelectorSettings paper_selector(SelectorKind kind, std::size_t budget) {
  SelectorSettings settings;
  settings.kind = kind;
  settings.budget = budget;
  settings.blocks.weighting = Weighting::map_bias;
  settings.search.strategy = Strategy::lazy_greedy;
  settings.search.threads = 1;
  return settings;
}

std::vector<TrackingOutcome> run_tracking(const WorldOptions& world_options,
                                          const std::vector<SelectorSettings>& selectors, const Trajectory& trajectory,
                                          std::uint64_t seed, std::uint64_t run) {
  struct Contestant {
    PoseTracker tracker;
    std::vector<StampedPose> estimate;
    TrackingOutcome outcome;
  };
  Draws seeds(seed ^ hash_of(trajectory.name), run);
  MappedWorld world(trajectory, world_options, seeds.bits());
  const Pose T_bc = euroc_T_bc(), T_cb = T_bc.inverse();
  std::vector<Contestant> contestants;
  for (SelectorSettings settings : selectors) {
    settings.seed = seeds.bits();
    contestants.push_back({PoseTracker(settings, (trajectory.poses.front().T_wb * T_bc).inverse()), {}, {}});
  }

  Frame frame;
  const auto frames = static_cast<double>(trajectory.poses.size());
  for (std::size_t i = 0; world.next(frame); ++i) {
    for (Contestant& one : contestants) {
      const TrackedFrame tracked = one.tracker.track(frame);
      one.estimate.push_back({trajectory.poses[i].time, tracked.T_cw.inverse() * T_cb});
      one.outcome.ms_outliers += tracked.ms_outliers / frames;
      one.outcome.ms_selection += tracked.ms_selection / frames;
      one.outcome.ms_pose += tracked.ms_pose / frames;
      one.outcome.matches += static_cast<double>(frame.matches.size()) / frames;
      one.outcome.used += static_cast<double>(tracked.selected.size()) / frames;
      one.outcome.lost += tracked.is_tracked ? 0 : 1;
    }
  }
  std::vector<TrackingOutcome> outcomes;
  for (Contestant& one : contestants) {
    one.outcome.errors = trajectory_errors(one.estimate, trajectory.poses);
    outcomes.push_back(one.outcome);
  }
  return outcomes;
}

}  // namespace maxlogdet::sim
