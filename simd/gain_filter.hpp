// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

// What evaluated gains prove of exact ones, and what that excludes: a filter of rounding errors, as those of geometric
// predicates (docs/numerics.md, which proves it). Always inlined, so that no unit of wide instructions exports them.

namespace maxlogdet::simd {

/// Half the distance from 1 to the next number: the largest relative error of one operation. Both are doubles, for
/// bounds are computed in float64.
constexpr double float_unit_roundoff = std::numeric_limits<float>::epsilon() / 2;
constexpr double double_unit_roundoff = std::numeric_limits<double>::epsilon() / 2;

/// Relative room for the roundings of a few float32 sums and products.
constexpr double sum_room = 1e-6;

/// Bounds are kept as float32, rounded up, and thresholds are rounded down: the next float32 at or beyond a value, with
/// room for the few roundings that lead to it.
constexpr double bound_room = 5e-7;
[[gnu::always_inline]] inline float rounded_down(double value) noexcept {
  return static_cast<float>(value - (value < 0 ? -value : value) * bound_room);
}
[[gnu::always_inline]] inline float rounded_up(double value) noexcept {
  return static_cast<float>(value + (value < 0 ? -value : value) * bound_room);
}

/// A threshold that every lane with a candidate reaches, and none without (relative gain -1).
constexpr float any_candidate = -0.5F;

/// A line above relative gains, for the maximum float32 value of a tile, rounded up; -1 if no candidate remains.
struct TileLine {
  float slope;
  float offset;
  [[gnu::always_inline]] float at(float highest) const noexcept {
    return highest < 0 ? -1.0F : slope * highest + offset;
  }
};

/// The interval in which an exact relative gain is, given the value v that was evaluated in float32 or float64, which
/// is off by at most
///     2 error sqrt(1 + v) + relative v + constant,
/// where the root is replaced by its tangent at a value near the best: nowhere below it, and no root to take.
struct GainFilter {
  double error = 0;
  double constant = 0;
  double relative = 0;

  /// Where the tangent is taken.
  double tangent = 0;
  double slope = 1;  ///< exact <= slope v + offset
  double offset = 0;

  [[gnu::always_inline]] void take_tangent_at(double relative_gain) noexcept {
    tangent = relative_gain;
    const double root = __builtin_sqrt(1 + relative_gain);
    slope = 1 + relative + error / root;
    offset = error * (root + 1 / root) + constant;
  }

  /// Moves the tangent to a relative gain that is more than four times as large, or as small, as where it is.
  [[gnu::always_inline]] void follow(double relative_gain) noexcept {
    constexpr double far = 4;
    const bool is_near = (1 + relative_gain) * far > 1 + tangent && 1 + relative_gain < far * (1 + tangent);
    if (!is_near) take_tangent_at(relative_gain);
  }

  /// A lower bound of an exact relative gain, given what was evaluated.
  [[gnu::always_inline]] double at_least(double relative_gain) const noexcept {
    return relative_gain - ((slope - 1) * relative_gain + offset);
  }

  /// A candidate whose evaluated gain is below this is not the best, if the best has at least `assured`.
  [[gnu::always_inline]] float survivor_threshold(double assured) const noexcept {
    const double threshold = (assured - offset) * (slope < 2 ? 2 - slope : 0);  // 2 - s <= 1 / s
    return threshold > 0 ? rounded_down(threshold) : any_candidate;
  }

  /// Upper bounds of the exact relative gains of a tile.
  [[gnu::always_inline]] TileLine line_of_tiles() const noexcept {
    return {rounded_up(slope * (1 + sum_room)), rounded_up(offset)};
  }
};

/// A tile whose stale bound is below this holds no candidate with an exact relative gain of at least `assured`:
/// (1 - drift) (1 + that) is at most 1 + the stale bound.
[[gnu::always_inline]] inline float stale_threshold(double assured, double drift) noexcept {
  const double threshold = assured > 0 ? assured - (1 + assured) * drift : 0;
  return threshold > 0 ? rounded_down(threshold) : any_candidate;
}

}  // namespace maxlogdet::simd
