// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"
#include "threading/team.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace maxlogdet {

/// The bits of floats >= 0 are ordered as the floats; those of negative floats are negative.
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

/// The bits that a bucket ignores: 32 buckets per octave, from `top` down.
constexpr int lane_order_shift = 18;

constexpr std::int32_t lane_order_buckets = 512;
constexpr std::size_t lane_order_counts = threading::Team::max_chunks * (lane_order_buckets + 1);

/// Lists the lanes with remaining[lane] > 0 by bucket of their values, which are >= 0, and within a bucket by lane.
/// bucket[lane] counts down from `top`, the maximum; values more than 16 octaves below it share the last bucket.
/// Returns how many. `counts`: scratch, lane_order_counts entries; too many for a real-time thread's stack.
std::size_t order_lanes(const float* values, const float* remaining, std::size_t lanes, float top,
                        threading::Team& team, std::uint32_t* counts, std::uint32_t* bucket, Lane* order) noexcept;

}  // namespace maxlogdet
