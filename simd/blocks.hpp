// SPDX-License-Identifier: MIT
#pragma once

#include "simd/camera_models.hpp"

#include <maxlogdet/weighting.hpp>

#include <cstddef>
#include <cstdint>

// Points and a pose in, blocks out: the arguments of append_blocks, already checked, as raw pointers and scalars. The
// equations are in maxlogdet/jacobian.hpp.

namespace maxlogdet::simd {

constexpr bool is_by_map_bias(Weighting weighting) {
  return weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
}

/// Why a match has no block, where the report says so.
enum InvalidMatch { unusable, behind_camera, too_near, singular_ray, invalid_covariance, invalid_match_count };

/// 2^39. Rounding moves A S A^T = I by up to 16u |Sigma_p| |A B|^2, with sums of magnitudes for |A B|: by more than
/// 1e-3 if |Sigma_p| |A B|^2 is above this, and then the covariance leaves no digits (docs/numerics.md).
constexpr double max_whitened_covariance = 549755813888.0;

/// A camera on the body that the pose is of.
struct CameraInput {
  CameraModel model;
  bool is_depth_along_z;  ///< min_depth bounds Z; else |p_c|
  double fx, fy, cx, cy, bf;
  Lens lens;
  const double* T_cb;  ///< 3 x 4 row-major; nullptr: I, the camera is its own body
};

struct BlockInput {
  Weighting weighting;
  DepthCue third;
  CameraInput camera;  ///< the first of `cameras`, by value: no store to the output can change it
  const CameraInput* cameras;
  std::size_t camera_count;
  const double* T_bw;  ///< 3 x 4 row-major, world to body
  double map_sigma;
  double depth_sigma;
  double min_depth;
  std::size_t size;
  const unsigned char* points;  ///< size x 3, float64 or float32, point_stride bytes from one to the next
  std::size_t point_stride;
  bool are_points_float;
  const double* sigmas;             ///< this and the following: size entries each, or null
  const unsigned char* has_third;   ///< nonzero each by default
  const unsigned char* usable;      ///< nonzero each by default
  const double* map_covariances;    ///< 3 x 3 each; map_sigma^2 I by default
  const unsigned char* camera_ids;  ///< which of `cameras`; the first by default
};

/// Whether blocks are made by the rows of J. A pinhole that is its own body, and by the map's bias any such camera,
/// goes along the ray: of a whole selection from 465 matches it saves 4 to 8 % (AVX-512) or 8 to 13 % (AVX2) of the
/// time.
inline bool is_by_jacobian(const BlockInput& input) {
  const bool is_seen_by_model = input.camera.model != CameraModel::pinhole && !is_by_map_bias(input.weighting);
  return input.camera_count > 1 || input.camera.T_cb != nullptr || is_seen_by_model;
}

struct BlockOutput {
  /// Of the valid matches only, in their order: entry (row, column) of the j-th goes to planes[(6 * row + column) *
  /// stride + j], for all rows < rows_written, zeros if it has no such row; indices[j] is first_index + its number.
  /// Nothing is written beyond place size - 1.
  float* planes;
  std::size_t stride;
  std::uint32_t* indices;
  unsigned char* validity;  ///< 1 or 0 per match
  std::uint32_t first_index;

  int rows_written;
  int rows;            ///< of the valid block with most rows, 0 if none is valid
  bool is_factored;    ///< whether the blocks are A [ I | -[p]x ] with an upper triangular A
  std::size_t stored;  ///< valid ones
  std::size_t invalid[invalid_match_count];
  double column_max[6];  ///< largest |entry| written, by column

  /// If they are factored, p, rounded to float32, goes to the 3 planes after the 18 of entries, and this is column_max
  /// of |A| [ I | |[p]x| ], with A and p rounded to float32.
  double factored_max[6];
};

using BuildBlocks = void (*)(const BlockInput& input, BlockOutput& output);

}  // namespace maxlogdet::simd
