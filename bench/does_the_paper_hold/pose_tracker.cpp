// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pose_tracker.hpp"

#include "bench/does_the_paper_hold/stopwatch.hpp"

#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

bool is_good(const Rejection& optimized) {
  return optimized.estimate.is_usable() && optimized.inliers.size() >= PoseTracker::min_inliers;
}

}  // namespace

PoseTracker::PoseTracker(const SelectorSettings& selection, const RejectionOptions& optimization)
    : selector_(selection), draws_(selection.seed), optimization_(optimization) {}

// Residuals are whitened with the same noise as blocks.
void PoseTracker::whiten_at(const Pose& T_cw, const Frame& frame) {
  if (!weighs_map_errors(selector_.settings())) return;
  const double* const covariances = frame.map_covariances.empty() ? nullptr : frame.map_covariances.front().data();
  whiten(frame.camera, T_cw, frame.matches, optimization_.stereo, covariances, selector_.settings().blocks.map_sigma,
         whitenings_);
}

std::vector<std::uint32_t> PoseTracker::select(const Frame& frame, const std::vector<std::uint32_t>& inliers) {
  const SelectorSettings& settings = selector_.settings();
  if (settings.kind != SelectorKind::observability) return selector_.select(frame, inliers);
  if (inliers.size() <= settings.budget) return inliers;
  return observability_.select(frame, inliers, settings.budget, settings.epsilon, draws_);
}

void PoseTracker::add_pose(const Pose& T_cw) {
  if (selector_.settings().kind == SelectorKind::observability) observability_.add_pose(T_cw);
}

void PoseTracker::start(const Pose& T_cw) {
  last_ = T_cw;
  velocity_ = Pose::Identity();
  add_pose(T_cw);
}

Pose PoseTracker::predict() const { return orthonormal(velocity_ * last_); }

TrackedFrame PoseTracker::track(Frame& frame) {
  TrackedFrame result;
  result.T_cw = predict();
  frame.T_cw_prior = to_rows(result.T_cw);
  std::vector<std::uint32_t> candidates(frame.matches.size());
  std::iota(candidates.begin(), candidates.end(), 0U);

  Stopwatch watch;
  Pose start = result.T_cw;
  whiten_at(start, frame);
  if (rejects_outliers(selector_.settings().kind)) {
    Rejection all = reject_outliers(frame.camera, frame.matches, candidates, start, optimization_, whitenings_);
    if (is_good(all)) {
      start = all.estimate.T_cw;
      whiten_at(start, frame);
    }
    result.inliers = std::move(all.inliers);
    frame.T_cw_prior = to_rows(start);
    watch.lap(result.ms_outliers);
    result.selected = select(frame, result.inliers);
    watch.lap(result.ms_selection);
  } else {
    result.selected = std::move(candidates);
  }
  Rejection optimized =
      reject_outliers(frame.camera, frame.matches, result.selected, start, optimization_, whitenings_);
  watch.lap(result.ms_pose);
  result.is_tracked = is_good(optimized);
  if (result.is_tracked) result.T_cw = optimized.estimate.T_cw;
  if (!rejects_outliers(selector_.settings().kind)) result.inliers = std::move(optimized.inliers);
  velocity_ = result.T_cw * last_.inverse();
  last_ = result.T_cw;
  add_pose(result.T_cw);
  return result;
}

}  // namespace maxlogdet::sim
