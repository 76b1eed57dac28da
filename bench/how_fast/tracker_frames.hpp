// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

// KITTI-like frames as a tracker passes them to the library, with their blocks.

namespace maxlogdet::bench {

struct Kind {
  const char* name;
  Weighting weighting;
  DepthCue depth_cue;
};
constexpr Kind monocular{"monocular", Weighting::measurement, DepthCue::none};
constexpr Kind stereo{"stereo_with_covariances", Weighting::measurement_and_map, DepthCue::stereo};
constexpr Kind kinds[] = {monocular, stereo};

/// Covariances of a frame's points, one per match, 3 x 3, world frame, m^2, if a stereo pair with the frame's camera
/// triangulated them from `distance` m behind its prior pose with standard deviations of `sigma` px times the match's
/// own: (J R)^-1 sigma^2 (J R)^-T. All points are in front of that pair.
std::vector<std::array<double, 9>> stereo_covariances(const sim::Frame& frame, double distance, double sigma);

/// A frame of n matches.
struct TrackerFrame {
  TrackerFrame(const Kind& kind, std::size_t n, std::uint64_t seed);
  TrackerFrame(const TrackerFrame&) = delete;
  TrackerFrame& operator=(const TrackerFrame&) = delete;

  void build(BlockStore& blocks) const;

  sim::Frame frame;  ///< without noise, at the true pose
  BlockOptions options;
  sim::MatchArrays arrays;

  // What a tracker has before it aligns: measurements, and points that have covariances, with noise as modelled, 12 %
  // of the matches moved by 5 to 40 px, and a pose that is off by 2 cm and 0.1 degrees.
  std::vector<FeatureMatch> measured;
  std::vector<unsigned char> is_wrong;
  RigidTransform T_predicted = nullptr;

 private:
  void measure(std::uint64_t seed);
};

constexpr std::size_t frame_count = 4;  ///< of each kind: branch predictors would learn a single frame
using TrackerFrames = std::deque<TrackerFrame>;

/// The frames that calls cycle through, made once and kept.
const TrackerFrames& frames_of(const Kind& kind, std::size_t n);

}  // namespace maxlogdet::bench
