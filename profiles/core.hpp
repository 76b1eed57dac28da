// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

// The two loops that measure the limits of a core with one instruction set. Like simd/kernel.hpp, this header is all
// that units compiled with wider instructions share with the rest.

namespace maxlogdet::profiles {

struct Core {
  const char* isa;
  int lanes;                 ///< float32 in a vector
  int instructions_per_fma;  ///< 1; 2 if a multiplication and an addition replace it
  int chains;                ///< independent accumulators, enough to hide the latency

  /// Does x <- x * factor + addend `steps` times on every chain; the result depends on all of it.
  float (*multiply_add)(std::size_t steps, float factor, float addend);
  /// Sums data[0, count) `passes` times; data is 64-byte aligned, count a multiple of sum_block.
  float (*sum)(const float* data, std::size_t count, std::size_t passes);
};

constexpr std::size_t sum_block = 128;  ///< 8 vectors of the widest instruction set

}  // namespace maxlogdet::profiles
