// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "simd/indices.hpp"
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

/// The bits that a bucket ignores: 32 buckets per octave, from the maximum down.
constexpr int lane_order_shift = 18;
constexpr std::int32_t lane_order_buckets = 512;

/// Memory of order_lanes for up to `capacity` candidates; too much for a real-time thread's stack.
struct LaneOrderMemory {
  explicit LaneOrderMemory(std::size_t capacity);
  AlignedArray<std::uint32_t> counts;
  ArrayOf<Lane, std::uint32_t> bucket;          ///< of each lane, before
  ArrayOf<Lane, Candidate> candidate;           ///< in the new order; those that do not remain come last
  ArrayOf<Tile, std::uint32_t> bucket_of_tile;  ///< of its first lane, in the new order
};

/// The lanes to order: those with remaining[lane] > 0, by their values, which are >= 0.
struct LanesToOrder {
  const float* values;
  const float* remaining;
  const Candidate* candidate;
  std::size_t count;
  float top;  ///< the maximum
};

/// Orders lanes by bucket of their values, which counts down from `top`, and within a bucket by lane; values more than
/// 16 octaves below it share the last bucket. Returns how many remain.
std::size_t order_lanes(const LanesToOrder& lanes, threading::Team& team, LaneOrderMemory& memory) noexcept;

}  // namespace maxlogdet
