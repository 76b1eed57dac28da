// SPDX-License-Identifier: MIT
#pragma once

#include "simd/rounding.hpp"

#include <cstdint>
#include <cstring>
#include <limits>

// What one error bound for all candidates excludes: the thresholds of a round, for Screening and for the kernels that
// do a whole round (docs/numerics.md, which proves them). Always inlined, as in rounding.hpp.

namespace maxlogdet {
namespace simd {

/// A threshold that every lane with a candidate reaches, and none without (relative gain -1).
constexpr float any_candidate = -0.5F;

/// A line above exact relative gains: exact <= slope * (that of float32) + offset.
struct UpperLine {
  double slope = 1;
  double offset = 0;

  /// A lower bound of an exact relative gain, given that of float32.
  [[gnu::always_inline]] double at_least(double relative_gain) const noexcept {
    return relative_gain - ((slope - 1) * relative_gain + offset);
  }
  [[gnu::always_inline]] double at_most(double relative_gain) const noexcept { return slope * relative_gain + offset; }

  /// A candidate whose float32 relative gain is below this is not the best, if the best has at least `assured`.
  [[gnu::always_inline]] float survivor_threshold(double assured) const noexcept {
    const double threshold = (assured - offset) * (slope < 2 ? 2 - slope : 0);  // 2 - s <= 1 / s
    return threshold > 0 ? rounded_down(threshold) : any_candidate;
  }
};

/// The same line for the maximum float32 value of a tile, rounded up; -1 if no candidate remains.
struct TileLine {
  float slope;
  float offset;
  [[gnu::always_inline]] float at(float highest) const noexcept {
    return highest < 0 ? -1.0F : slope * highest + offset;
  }
};
[[gnu::always_inline]] inline TileLine rounded_up(const UpperLine& line) noexcept {
  return {rounded_up(line.slope * (1 + sum_room)), rounded_up(line.offset)};
}

/// A tile whose stale bound is below this holds no candidate with an exact relative gain of at least `assured`:
/// (1 - drift) (1 + that) is at most 1 + the stale bound.
[[gnu::always_inline]] inline float stale_threshold(double assured, double drift) noexcept {
  const double threshold = assured > 0 ? assured - (1 + assured) * drift : 0;
  return threshold > 0 ? rounded_down(threshold) : any_candidate;
}

/// The next float below a value that is not NaN, -infinity below -infinity, so that two ranges of bounds meet without
/// overlapping: std::nextafter without a call.
[[gnu::always_inline]] inline float next_below(float value) noexcept {
  std::uint32_t bits;
  if (value == 0 || value < -std::numeric_limits<float>::max()) {
    return value == 0 ? -std::numeric_limits<float>::denorm_min() : value;
  }
  std::memcpy(&bits, &value, sizeof bits);
  bits = value > 0 ? bits - 1 : bits + 1;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace simd
}  // namespace maxlogdet
