// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

// Points and a pose in, blocks out: what append_blocks asks of an instruction set. Raw pointers and scalars only, as in
// simd/kernel.hpp, and already checked. The equations are in maxlogdet/jacobian.hpp.

namespace maxlogdet {
namespace simd {

// In the order of the public enumerations; kernel/jacobian.cpp asserts it.
enum class BlockWeighting { map_bias, map_bias_world, measurement, measurement_and_map };
enum class ThirdRow { none, stereo, depth };

struct BlockInput {
  BlockWeighting weighting;
  ThirdRow third;
  double fx, fy, bf;
  const double* T_cw;  ///< 3 x 4 row-major
  double map_sigma;
  double depth_sigma;
  std::size_t size;
  const double* points;            ///< size x 3
  const double* sigmas;            ///< this and the following: size entries each, or null
  const double* weights;           ///< 1 each by default
  const unsigned char* has_third;  ///< nonzero each by default
  const unsigned char* usable;     ///< nonzero each by default
  const double* map_covariances;   ///< 3 x 3 each; map_sigma^2 I by default
};

struct BlockOutput {
  /// Entry (row, column) of match i goes to planes[(6 * row + column) * stride + i], for all rows < rows_written; zeros
  /// where it is invalid or has no such row. Nothing is written beyond match size - 1.
  float* planes;
  std::size_t stride;
  unsigned char* validity;  ///< 1 or 0 a match

  int rows_written;
  int rows;  ///< of the tallest valid block, 0 if none is valid
  std::size_t invalid;
  std::size_t behind_camera;
  std::size_t singular_rays;
  double column_max[6];  ///< largest |entry| written, by column
};

using BuildBlocks = void (*)(const BlockInput& input, BlockOutput& output);

}  // namespace simd
}  // namespace maxlogdet
