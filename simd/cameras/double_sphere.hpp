// SPDX-License-Identifier: MIT
#pragma once

#include "simd/cameras/model.hpp"

namespace maxlogdet::simd {
namespace {

// m = (X, Y) / D, dD = g (X dX + Y dY) + h dZ.
template <>
struct Model<CameraModel::double_sphere> : DefaultModel {
  static constexpr std::size_t parameter_count = 2;
  static constexpr bool is_depth_along_z = false;

  static bool are_valid(const double* k) { return k[0] > -1 && k[1] >= 0 && k[1] <= 1; }

  // -w_2 of the paper: points have an image only where Z / |p_c| is above this.
  static double prepare(const double* k) {
    const double xi = k[0];
    const double alpha = k[1];
    const double w1 = alpha > 0.5 ? (1 - alpha) / alpha : alpha / (1 - alpha);
    return -(w1 + xi) / std::sqrt(2 * w1 * xi + xi * xi + 1);
  }

  template <class Number>
  [[gnu::always_inline]] static Image<Number> project(const Lens& lens, const PointOf<Number>& p) {
    const Number zero(0.0);
    const Number one(1.0);
    const Number xi(lens.parameters[0]);
    const Number alpha(lens.parameters[1]);
    const Number beta(1 - lens.parameters[1]);
    const Number r_squared = p.x * p.x + p.y * p.y;
    const Number norm_squared = r_squared + p.z * p.z;
    const Number d1 = sqrt(norm_squared);
    const Number k = xi * d1 + p.z;
    const Number d2 = sqrt(r_squared + k * k);
    const Number shift = xi / d1;
    const Number share = alpha / d2;
    const Number inverse = one / (alpha * d2 + beta * k);
    const Number square = inverse * inverse;
    const Number g = (share * (one + k * shift) + beta * shift) * square;
    const Number by_z = (shift * p.z + one) * (share * k + beta) * square;
    const Number xy = negated(g * p.x * p.y);
    const Number rise = (inverse - g * r_squared) * p.z + by_z * r_squared;  // of |m| with the angle to the axis
    const ConditionOf<Number> exists =
        (inverse > zero) & (p.z > Number(lens.prepared) * d1) & (rise > zero) & is_finite(norm_squared);
    return {p.x * inverse,
            p.y * inverse,
            {inverse - g * p.x * p.x, xy, negated(by_z * p.x)},
            {xy, inverse - g * p.y * p.y, negated(by_z * p.y)},
            exists};
  }
};

}  // namespace
}  // namespace maxlogdet::simd
