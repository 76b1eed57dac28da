// SPDX-License-Identifier: MIT
#pragma once

#include "simd/camera_models.hpp"

#include <maxlogdet/feature_match.hpp>

#include <cstddef>
#include <cstdint>

// What is made of checked matches at a pose: blocks (maxlogdet/block_store.hpp has the equations), and the steps of a
// robust alignment (docs/alignment.md). float64, nothing fused, sums in one order: the same bits on every instruction
// set.

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

// The steps of a robust alignment: residuals and their derivatives at a pose, their median, and the weighted normal
// equations.

/// Matches are summed by their lane modulo this, whatever the width of a pack.
constexpr std::size_t alignment_lanes = 8;

/// What is known of a match, a plane of float64 each.
namespace plane {
constexpr std::size_t point = 0;           // 3, p_w
constexpr std::size_t measured = 3;        // 3: u, v, and u_right or the depth
constexpr std::size_t sigma = 6;           // of u, v, u_right
constexpr std::size_t weight = 7;          // 1 / sigma
constexpr std::size_t has_third = 8;       // 1 or 0
constexpr std::size_t map_covariance = 9;  // 6, the upper triangle, by rows
constexpr std::size_t given = 15;          // those above
constexpr std::size_t whitening = 15;      // 6, the upper triangle of W, by rows
constexpr std::size_t error = 21;          // |W e|^2, over its median if it is normal; infinite without an image
constexpr std::size_t is_inlier = 22;      // 1 or 0
constexpr std::size_t leverage = 23;       // |W J|^2 at the predicted pose, then Mallows' weight
constexpr std::size_t count = 24;
}  // namespace plane

/// Squared limits of |W e| by its degrees of freedom, 2 or 3: with normal errors as many pass with three as with two.
struct RobustLimits {
  double median;  ///< of chi-squared
  double huber;   ///< (1.5)^2 of two: full weight below it
  double tukey;   ///< (4.7)^2 of two: no weight above it
  double gate;    ///< the 99 % quantile: inliers are below it
};
constexpr RobustLimits robust_limits[] = {
    {1.3862943611198906, 2.25, 22.09, 9.210340371976184},
    {2.3659738843753377, 3.4701636117408556, 24.930378113862496, 11.344866730144373}};

/// Huber's limit over the squared error of a match without weight, (20)^2 of two: the influence of an error is bounded,
/// but not of its derivative, which may be anything of a point that is wrongly near.
constexpr double smallest_huber_ratio = 2.25 / 400;

/// How a match counts: by its squared error, or whether it is an inlier.
enum class RobustWeight { huber, tukey, inliers };

/// Consecutive matches of one camera, a whole number of alignment_lanes; lanes beyond the last match have a NaN point.
struct AlignmentInput {
  CameraInput camera;
  const double* T_bw;  ///< 3 x 4 row-major, world to body
  DepthCue third;      ///< what third rows measure
  double depth_sigma;
  bool by_map;     ///< W is plane::whitening, of the noise of measurement and map; else it is by sigma
  double* planes;  ///< plane v of lane i is at planes[v * stride + i]
  std::size_t stride;
  float* errors;           ///< plane::error, rounded to float32
  std::size_t begin, end;  ///< lanes
};

/// Of H^T W H and H^T W e, H = J [ I | -[p]x ]: with G = J^T W J and g = J^T W e they are made of these sums.
struct NormalSums {
  double G[6];       ///< the upper triangle, by rows
  double cross[9];   ///< -G [p]x, by rows
  double turned[6];  ///< [p]x G [p]x^T, the upper triangle, by rows
  double g[3];
  double moment[3];  ///< p x g
};

/// How many third rows there are, and how many of them are below -limit and above it.
struct ThirdRows {
  std::size_t count, below, above;
};

struct AlignmentFunctions {
  /// W of matches with noise of the map, at the pose; NaN where there is none.
  void (*whiten)(const AlignmentInput& input);
  /// plane::leverage, also to errors.
  void (*measure_leverage)(const AlignmentInput& input);
  /// plane::error and errors at the pose.
  void (*measure_errors)(const AlignmentInput& input);
  /// Counts the third rows, whose errors u and v cannot explain, at the pose.
  ThirdRows (*count_third)(const AlignmentInput& input, double limit);
  /// The sums at the pose, weighted by plane::error over `scale_squared`, or by plane::is_inlier.
  NormalSums (*normal_equations)(const AlignmentInput& input, RobustWeight weight, double scale_squared);
};

}  // namespace maxlogdet::simd
