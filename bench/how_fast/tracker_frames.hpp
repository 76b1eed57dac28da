// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

// KITTI-like frames as a tracker passes them to the library, with their blocks.

namespace maxlogdet::bench {

struct Kind {
  const char* name;
  Weighting weighting;
  DepthCue depth_cue;
};
constexpr Kind monocular{"2_rows_measurement", Weighting::measurement, DepthCue::none};
constexpr Kind stereo{"3_rows_measurement", Weighting::measurement, DepthCue::stereo};
constexpr Kind stereo_map{"3_rows_measurement_and_map", Weighting::measurement_and_map, DepthCue::stereo};
constexpr Kind kinds[] = {monocular, stereo, stereo_map};

/// Which frames: each has `slots` matches, of which n may be selected. `rest` says whether the others are left out or
/// not usable.
enum class Rest { absent, unusable };
struct Which {
  Kind kind;
  std::size_t n;
  std::size_t slots;
  Rest rest = Rest::absent;
};

struct TrackerFrame {
  TrackerFrame(const Which& which, std::uint64_t seed);

  void build(BlockStore& blocks) const;

  sim::Frame frame;  ///< without noise, at the true pose
  BlockOptions options;
  std::unique_ptr<sim::MatchArrays> arrays;
  Matches matches;
  std::vector<unsigned char> is_usable;
  BlockStore store;

  // What a tracker has before it aligns: measurements, and points that have covariances, with noise as modelled, 12 %
  // of the matches moved by 5 to 40 px, and a pose that is off by 2 cm and 0.1 degrees.
  std::vector<FeatureMatch> measured;
  std::vector<unsigned char> is_wrong;
  RigidTransform T_predicted = nullptr;

 private:
  void measure(const std::vector<std::uint32_t>& order, std::uint64_t seed);
};

using TrackerFrames = std::vector<std::unique_ptr<TrackerFrame>>;

constexpr std::size_t frame_count = 4;  ///< of each kind: branch predictors would learn a single frame

/// The frames are made once and kept.
const TrackerFrames& frames_of(const Which& which);

/// The frame that a call selects from: calls cycle through all of them.
inline const TrackerFrame& frame_of(const TrackerFrames& frames, std::size_t call) {
  return *frames[call % frames.size()];
}

}  // namespace maxlogdet::bench
