// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"
#include "threading/team.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace maxlogdet {

/// Bits of floats >= 0 are ordered as the floats are; those of others are negative.
inline std::int32_t bits_of(float value) noexcept {
  std::int32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

inline float float_of(std::int32_t bits) noexcept {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// Steps of values: 32 to an octave, from `top` down.
constexpr int lane_order_shift = 18;

constexpr std::int32_t lane_order_buckets = 512;
constexpr std::size_t lane_order_counts = threading::Team::max_chunks * (lane_order_buckets + 1);

/// Lists the lanes with remaining[lane] > 0 by descending value, >= 0, to a step, and in their own order within one;
/// those more than 16 octaves below `top`, which is the largest value, come last. Returns how many; bucket[lane] is the
/// number of steps from the top. `counts`: scratch, lane_order_counts entries; too many for a real-time thread's stack.
std::size_t order_lanes(const float* values, const float* remaining, std::size_t lanes, float top,
                        threading::Team& team, std::uint32_t* counts, std::uint32_t* bucket,
                        std::uint32_t* order) noexcept;

}  // namespace maxlogdet
