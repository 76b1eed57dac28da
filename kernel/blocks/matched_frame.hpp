// SPDX-License-Identifier: MIT
#pragma once

#include "simd/camera_models.hpp"

#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>

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

/// What a match has measured besides u and v.
DepthCue measured_cue(const FeatureMatch& match) noexcept;
bool is_measured(const FeatureMatch& match) noexcept;
/// Whether its numbers can be computed with: squares of some that are far larger would overflow.
bool is_sound(const FeatureMatch& match) noexcept;

/// A frame: cameras on a body, the pose of the body, and the matches. Arrays are the caller's.
struct MatchedFrame {
  const Camera* cameras = nullptr;
  std::size_t camera_count = 0;
  RigidTransform T_bw = nullptr;
  const FeatureMatch* matches = nullptr;
  std::size_t size = 0;
  const unsigned char* usable = nullptr;  ///< per match, nonzero if it is used; each by default
  BlockOptions options;

  DepthCue depth_cue = DepthCue::none;  ///< of the matches, this and the following
  bool has_mixed_cues = false;          ///< some have a right column, and some a depth
  bool has_covariances = false;

  /// Whether the camera that has seen the match is there; an error of the frame is that there is none at all.
  bool has_camera_of(const FeatureMatch& match) const noexcept {
    return match.camera_id < camera_count || camera_count == 0;
  }
  /// Takes up what a sound match has.
  void note(const FeatureMatch& match) noexcept;
};

/// Returns the first error, or none.
Error check(const Camera& camera, DepthCue third) noexcept;
Error check(const MatchedFrame& frame) noexcept;

/// append_blocks() of a frame, for its usable matches; the others become invalid candidates.
BlockReport append_blocks(const MatchedFrame& frame, BlockStore& blocks);

}  // namespace maxlogdet
