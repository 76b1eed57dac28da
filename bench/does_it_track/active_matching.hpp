// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/matcher.hpp"
#include "bench/does_it_track/tracker_options.hpp"
#include "bench/world/draws.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stereo_odometry {

/// Matches points of the map until as many are found as the budget says: in the order of their information, which the
/// library proposes, or in random order. In batches, by ActiveSelection, because the matcher takes several points at
/// once; trackers that match one by one call GoodFeatures::match. Reuses its memory.
class ActiveMatching {
 public:
  explicit ActiveMatching(std::uint64_t seed) : draws_(seed) {}

  /// Adds matches that agree with T_cw, which is also the prior pose of the matcher's frame, to a matcher that has
  /// started a frame. Adds the times of matching and selection to `ms`. Returns how many points were searched for.
  std::size_t match(const LocalMap& map, Matcher& matcher, const maxlogdet::sim::Pose& T_cw,
                    const maxlogdet::sim::MotionNoise& noise, const TrackerOptions& options, StageTimes& ms);

 private:
  void start_by_information(const LocalMap& map, Matcher& matcher, const std::vector<unsigned char>& is_candidate,
                            const maxlogdet::sim::MotionNoise& noise, const TrackerOptions& options);
  void propose_at_random(std::size_t count);

  maxlogdet::sim::Draws draws_;
  std::vector<double> sigmas_;  // of the predictions of the map's points
  maxlogdet::BlockStore blocks_;
  maxlogdet::ActiveSelection active_{1};
  std::vector<std::uint32_t> order_;  // the candidates at random, those to come
  std::vector<std::uint32_t> proposals_;
};

}  // namespace stereo_odometry
