// SPDX-License-Identifier: MIT
#include "sim/pose_tracker.hpp"

#include <chrono>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Adds the time since the last lap to `ms`.
class Stopwatch {
 public:
  void lap(double& ms) {
    const auto now = Clock::now();
    ms += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

// Products of rotations drift from rotations, and constant velocity would multiply the drift with every frame.
Pose rigid(Pose T) {
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return T;
}

bool is_good(const Rejection& optimized) {
  return optimized.estimate.is_usable() && optimized.inliers.size() >= PoseTracker::least_inliers;
}

}  // namespace

PoseTracker::PoseTracker(const SelectorSettings& selection, const RejectionOptions& optimization)
    : selector_(selection), optimization_(optimization) {
  if (selection.kind != SelectorKind::all_weighted) optimization_.map_sigma = 0;
}

void PoseTracker::start(const Pose& T_cw) {
  last_ = T_cw;
  velocity_ = Pose::Identity();
  selector_.add_pose(T_cw);
}

Pose PoseTracker::predict() const { return rigid(velocity_ * last_); }

TrackedFrame PoseTracker::track(Frame& frame) {
  TrackedFrame result;
  result.T_cw = predict();
  frame.T_cw_prior = to_rows(result.T_cw);
  std::vector<std::uint32_t> candidates(frame.matches.size());
  std::iota(candidates.begin(), candidates.end(), 0U);

  Stopwatch watch;
  Pose start = result.T_cw;
  if (rejects_outliers(selector_.settings().kind)) {
    Rejection all = reject_outliers(frame.camera, frame.matches, candidates, start, optimization_);
    if (is_good(all)) start = all.estimate.T_cw;
    result.inliers = std::move(all.inliers);
    frame.T_cw_prior = to_rows(start);
    watch.lap(result.ms_outliers);
    result.selected = selector_.select(frame, result.inliers);
    watch.lap(result.ms_selection);
  } else {
    result.selected = std::move(candidates);
  }
  Rejection optimized = reject_outliers(frame.camera, frame.matches, result.selected, start, optimization_);
  watch.lap(result.ms_pose);
  result.is_tracked = is_good(optimized);
  if (result.is_tracked) result.T_cw = optimized.estimate.T_cw;
  if (!rejects_outliers(selector_.settings().kind)) result.inliers = std::move(optimized.inliers);
  velocity_ = result.T_cw * last_.inverse();
  last_ = result.T_cw;
  selector_.add_pose(result.T_cw);
  return result;
}

}  // namespace maxlogdet::sim
