// SPDX-License-Identifier: MIT
#pragma once

#include "simd/cameras/angle.hpp"
#include "simd/cameras/model.hpp"

namespace maxlogdet::simd {
namespace {

// m = d (X, Y) / r: along the radius it changes by d' / R, across it by d / r.
template <>
struct Model<CameraModel::kannala_brandt> : DefaultModel {
  static constexpr std::size_t parameter_count = 4;
  static constexpr bool is_depth_along_z = false;

  template <class Number>
  [[gnu::always_inline]] static Image<Number> project(const Lens& lens, const PointOf<Number>& p) {
    const double* const k = lens.parameters;
    const Number zero(0.0);
    const Number one(1.0);
    const Number r_squared = p.x * p.x + p.y * p.y;
    const Number norm_squared = r_squared + p.z * p.z;
    const Number r = sqrt(r_squared);
    const Number theta = angle_to_axis(r, p.z, sqrt(norm_squared));
    const Number q = theta * theta;
    const Number d = theta * (one + q * (Number(k[0]) + q * (Number(k[1]) + q * (Number(k[2]) + q * Number(k[3])))));
    const Number slope =
        one + q * (Number(3 * k[0]) + q * (Number(5 * k[1]) + q * (Number(7 * k[2]) + q * Number(9 * k[3]))));
    const ConditionOf<Number> is_off_axis = r > zero;
    const Number inverse_r = select(is_off_axis, one / r, zero);
    const Number x = p.x * inverse_r;
    const Number y = p.y * inverse_r;
    const Number across = select(is_off_axis, d * inverse_r, one / p.z);
    const Number by_z = slope / norm_squared;
    const Number along = by_z * p.z - across;
    const Number xy = along * (x * y);
    const ConditionOf<Number> exists =
        (slope > zero) & ((is_off_axis & (d > zero)) | (p.z > zero)) & is_finite(norm_squared);
    return {across * p.x,
            across * p.y,
            {across + along * (x * x), xy, negated(by_z * p.x)},
            {xy, across + along * (y * y), negated(by_z * p.y)},
            exists};
  }
};

}  // namespace
}  // namespace maxlogdet::simd
