// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

// What a core can do with one instruction set: the two loops that measure it. Like simd/kernel.hpp, this header is all
// that units compiled with wider instructions share with the rest.

namespace maxlogdet::profiles {

struct Core {
  const char* isa;
  int lanes;                 ///< float32 in a vector
  int instructions_per_fma;  ///< 1, or 2 where a multiplication and an addition stand in for it
  int chains;                ///< independent accumulators, as many as hide the latency

  /// `steps` times x <- x * factor + addend on every chain; returns something that depends on all of it.
  float (*multiply_add)(std::size_t steps, float factor, float addend);
  /// Adds up data[0, count) `passes` times: 64-byte aligned, count a multiple of sum_block.
  float (*sum)(const float* data, std::size_t count, std::size_t passes);
};

constexpr std::size_t sum_block = 128;  ///< 8 vectors of the widest instruction set

}  // namespace maxlogdet::profiles
