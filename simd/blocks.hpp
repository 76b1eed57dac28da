// SPDX-License-Identifier: MIT
#pragma once

#include "simd/camera_models.hpp"

#include <maxlogdet/feature_match.hpp>

#include <cstddef>

// Matches and a pose in, blocks out: the arguments of append_blocks, already checked. The equations are in
// maxlogdet/block_store.hpp.

namespace maxlogdet::simd {

/// 2^39. Rounding moves A S A^T = I by up to 16u |Sigma_p| |A B|^2, with sums of magnitudes for |A B|: by more than
/// 1e-3 if |Sigma_p| |A B|^2 is above this, and then the covariance leaves no digits (docs/numerics.md).
constexpr double max_whitened_covariance = 549755813888.0;

/// Entry e of the upper triangle of a point's covariance, by rows; of map_sigma^2 I where it is unknown.
[[gnu::always_inline]] inline double map_covariance_of(const FeatureMatch& match, double map_sigma, std::size_t e) {
  constexpr std::size_t entries[6] = {0, 1, 2, 4, 5, 8};
  const std::size_t entry = entries[e];
  if (match.covariance != nullptr) return match.covariance[entry];
  return entry % 4 == 0 ? map_sigma * map_sigma : 0;
}

/// Matches in a pack of the widest instruction set.
constexpr std::size_t most_double_lanes = 8;

struct BlockInput {
  const FeatureMatch* matches;
  std::size_t size;
  const unsigned char* usable;  ///< per match, nonzero each by default
  DepthCue third;               ///< what third rows measure, for the matches that have it
  bool by_map;                  ///< whether the covariances of the points count; map_sigma^2 I where one is null
  const CameraInput* cameras;
  std::size_t camera_count;
  const double* T_bw;  ///< 3 x 4 row-major, world to body
  double map_sigma;
  double depth_sigma;
};

struct BlockOutput {
  /// Entry (row, column) of match i goes to planes[(6 * row + column) * stride + i], for rows_with(third) rows: zeros
  /// without a block, and where it has no third row. Whole packs are written, up to most_double_lanes - 1 too much.
  float* planes;
  std::size_t stride;
  unsigned char* validity;  ///< 1 or 0 per match

  bool has_three_rows;                                              ///< whether a block has
  std::size_t valid, unusable, behind_camera, invalid_covariances;  ///< to these is added
  double column_max[6];                                             ///< largest |entry| by column

  /// Three rows are A [ I | -[p]x ], with an upper triangular A: p, rounded to float32, goes to the 3 planes after the
  /// 18 of entries. This is column_max of |A| [ I | |[p]x| ], at least that of A and p rounded to float32; infinite
  /// where these are not used.
  double factored_max[6];
};

using BuildBlocks = void (*)(const BlockInput& input, BlockOutput& output);

}  // namespace maxlogdet::simd
