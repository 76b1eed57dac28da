// SPDX-License-Identifier: MIT
#include "bench/does_it_track/active_matching.hpp"

#include "bench/world/stopwatch.hpp"

#include <algorithm>
#include <cmath>

namespace stereo_odometry {

using maxlogdet::sim::MotionNoise;
using maxlogdet::sim::Pose;

// Candidates are the points in view that the last keyframe has seen: of the others only one proposal in ten was found.
std::size_t ActiveMatching::match(const LocalMap& map, Matcher& matcher, const Pose& T_cw, const MotionNoise& noise,
                                  const TrackerOptions& options, StageTimes& ms) {
  maxlogdet::sim::Stopwatch watch;
  const maxlogdet::sim::RejectionOptions gate = options.at_coarse_pose();
  const auto& candidates = matcher.predict(map.points(), T_cw, map.first_of_last(options.candidate_keyframes));
  const std::size_t budget = std::min(options.selection.budget, candidates.size());
  const std::vector<unsigned char>& is_candidate = matcher.is_predicted(map.points());
  watch.lap(ms.matching);
  if (options.random_order) {
    order_.clear();
    for (const Prediction& candidate : candidates) order_.push_back(candidate.point);
    draws_.shuffle_front(order_, order_.size());
  } else {
    start_by_information(map, matcher, is_candidate, noise, options);
  }
  std::size_t searched = 0;
  for (;;) {
    if (options.random_order) {
      propose_at_random(std::min(options.batch, budget - matcher.matches().size()));
    } else {
      proposals_.resize(std::min(options.batch, budget));
      proposals_.resize(active_.next(proposals_.data(), proposals_.size()));
    }
    watch.lap(ms.selection);
    if (proposals_.empty()) return searched;
    const std::vector<unsigned char>& is_matched = matcher.match_some(map, proposals_, options.fine_radius, T_cw, gate);
    searched += proposals_.size();
    watch.lap(ms.matching);
    if (!options.random_order) active_.answer(is_matched.data(), is_matched.size());
  }
}

// Makes blocks of the predictions at the coarse pose, from the map's own arrays.
void ActiveMatching::start_by_information(const LocalMap& map, Matcher& matcher,
                                          const std::vector<unsigned char>& is_candidate, const MotionNoise& noise,
                                          const TrackerOptions& options) {
  maxlogdet::Matches points = map.points().arrays();
  points.usable = is_candidate.data();
  sigmas_.assign(points.size, 1);
  for (const Prediction& seen : matcher.predictions()) {
    const cv::Point2f& from = map.points().points[seen.point].pixel;
    sigmas_[seen.point] = std::sqrt(noise.variance(std::hypot(seen.u - from.x, seen.v - from.y)));
  }
  points.sigmas = sigmas_.data();
  const maxlogdet::sim::Frame& frame = matcher.frame();
  blocks_.clear();
  append_blocks(frame.camera, maxlogdet::RigidTransform::row_major(frame.T_cw_prior.data()), points,
                options.selection.blocks, blocks_);
  if (active_.capacity() < blocks_.size()) active_ = maxlogdet::ActiveSelection(2 * blocks_.size());
  maxlogdet::Options search = options.selection.search;
  search.budget = std::min(options.selection.budget, matcher.predictions().size());
  active_.start(blocks_, search);
}

void ActiveMatching::propose_at_random(std::size_t count) {
  const std::size_t left = order_.size() - std::min(count, order_.size());
  proposals_.assign(order_.begin() + static_cast<std::ptrdiff_t>(left), order_.end());
  order_.resize(left);
}

}  // namespace stereo_odometry
