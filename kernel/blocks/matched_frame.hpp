// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/memory.hpp"
#include "simd/camera_models.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace maxlogdet {

/// The maximum number of cameras: as many as an id of one byte distinguishes.
constexpr std::size_t max_cameras = 256;

inline bool all_finite(const double* values, std::size_t count) noexcept {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}
inline bool is_positive(double value) noexcept { return value > 0 && std::isfinite(value); }

/// Whether all entries are finite, R R^T = I within 1e-3, and det R > 0.
bool is_rigid(const RigidTransform& transform) noexcept;
bool is_identity(const RigidTransform& transform) noexcept;

/// Whether it is one of the enumerators.
bool is_known(CameraModel model) noexcept;
/// The camera as kernels read it, a view. The model is known.
simd::CameraInput camera_input(const Camera& camera) noexcept;

inline bool has_right(const FeatureMatch& match) noexcept { return match.u_right >= 0 && match.u_right < infinity; }
inline bool has_depth(const FeatureMatch& match) noexcept { return is_positive(match.depth); }
inline bool is_measured(const FeatureMatch& match) noexcept { return match.measured[0] != unmeasured; }
/// What a match has measured besides u and v.
inline DepthCue measured_cue(const FeatureMatch& match) noexcept {
  if (has_right(match)) return DepthCue::stereo;
  return has_depth(match) ? DepthCue::depth : DepthCue::none;
}
/// Whether its numbers can be computed with: squares of some that are far larger would overflow.
inline bool is_sound(const FeatureMatch& match) noexcept {
  constexpr double most = 1e15;  // of a pixel and of a standard deviation
  const bool is_moderate = std::abs(match.measured[0]) < most && std::abs(match.measured[1]) < most;
  return all_finite(match.point, 3) && (is_moderate || !is_measured(match)) && match.sigma > 1 / most &&
         match.sigma < most;
}

/// A frame: cameras on a body, the pose of the body, and the matches. Arrays are the caller's.
struct MatchedFrame {
  const Camera* cameras = nullptr;
  std::size_t camera_count = 0;
  RigidTransform T_bw = nullptr;
  const FeatureMatch* matches = nullptr;
  std::size_t size = 0;
  const unsigned char* usable = nullptr;  ///< per match, nonzero if it is used; each by default
  BlockOptions options = {};

  DepthCue depth_cue = DepthCue::none;  ///< of the matches, this and the following
  bool has_mixed_cues = false;          ///< some have a right column, and some a depth
  bool has_covariances = false;

  /// Whether the camera that has seen the match is there. True without any camera, which check() reports.
  bool has_camera_of(const FeatureMatch& match) const noexcept {
    return match.camera_id < camera_count || camera_count == 0;
  }
  /// Takes up what a sound match has.
  void note(const FeatureMatch& match) noexcept {
    has_covariances = has_covariances || match.covariance != nullptr;
    const DepthCue cue = measured_cue(match);
    if (cue == DepthCue::none) return;
    const bool has_both = has_right(match) && has_depth(match);
    has_mixed_cues = has_mixed_cues || has_both || (depth_cue != DepthCue::none && depth_cue != cue);
    depth_cue = cue;
  }
};

/// Returns the first error, or none.
Error check(const Camera& camera, DepthCue third) noexcept;
Error check(const MatchedFrame& frame) noexcept;

/// append_blocks() of a frame, for its usable matches; the others become invalid candidates.
BlockReport append_blocks(const MatchedFrame& frame, BlockStore& blocks);

}  // namespace maxlogdet
