// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

// The rounding of float32 and float64, for the error bounds of docs/numerics.md.

namespace maxlogdet::simd {

/// Half the distance from 1 to the next number: the largest relative error of one operation. Both are doubles, for
/// bounds are computed in float64.
constexpr double float_unit_roundoff = std::numeric_limits<float>::epsilon() / 2;
constexpr double double_unit_roundoff = std::numeric_limits<double>::epsilon() / 2;

/// Relative room for the roundings of a few float32 sums and products.
constexpr double sum_room = 1e-6;

/// Bounds are kept as float32, rounded up, and thresholds are rounded down: the next float32 at or beyond a value, with
/// room for the few roundings that lead to it. Always inlined, so that no unit of wide instructions exports them.
constexpr double bound_room = 5e-7;
[[gnu::always_inline]] inline float rounded_down(double value) noexcept {
  return static_cast<float>(value - (value < 0 ? -value : value) * bound_room);
}
[[gnu::always_inline]] inline float rounded_up(double value) noexcept {
  return static_cast<float>(value + (value < 0 ? -value : value) * bound_room);
}

}  // namespace maxlogdet::simd
