// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet {
namespace simd {

/// u: the largest relative error of one rounding to nearest.
constexpr double float_unit_roundoff = 5.9604644775390625e-8;            ///< 2^-24
constexpr double double_unit_roundoff = 1.1102230246251565404236317e-16;  ///< 2^-53

}  // namespace simd
}  // namespace maxlogdet
