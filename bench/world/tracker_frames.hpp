// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

// KITTI-like frames as a tracker passes them to the library, with their blocks.

namespace maxlogdet::sim {

struct TrackerKind {
  const char* name;
  DepthCue depth_cue;
  bool has_covariances;
};
constexpr TrackerKind monocular_tracker{"monocular", DepthCue::none, false};
constexpr TrackerKind stereo_tracker{"stereo_with_covariances", DepthCue::stereo, true};
constexpr TrackerKind tracker_kinds[] = {monocular_tracker, stereo_tracker};

/// A frame of n matches.
struct TrackerFrame {
  TrackerFrame(const TrackerKind& kind, std::size_t n, std::uint64_t seed);
  TrackerFrame(const TrackerFrame&) = delete;
  TrackerFrame& operator=(const TrackerFrame&) = delete;

  void build(BlockStore& blocks) const;

  Frame frame;                      ///< without noise, at the true pose
  std::vector<FeatureMatch> exact;  ///< its matches; of a stereo frame all are stereo

  // What a tracker has before it aligns: measurements, and points that have covariances, with noise as modelled, 12 %
  // of the matches moved by 5 to 40 px, and a pose that is off by 2 cm and 0.1 degrees.
  std::vector<FeatureMatch> measured;
  std::vector<unsigned char> is_wrong;
  RigidTransform T_predicted = nullptr;

 private:
  void measure(const TrackerKind& kind, std::uint64_t seed);
};

constexpr std::size_t frame_count = 4;  ///< of each kind: branch predictors would learn a single frame
using TrackerFrames = std::deque<TrackerFrame>;

/// The frames that calls cycle through, made once and kept.
const TrackerFrames& frames_of(const TrackerKind& kind, std::size_t n);

}  // namespace maxlogdet::sim
