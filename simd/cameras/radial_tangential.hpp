// SPDX-License-Identifier: MIT
#pragma once

#include "simd/cameras/model.hpp"

namespace maxlogdet::simd {
namespace {

// With x = X / Z, y = Y / Z, G = d (m_x, m_y) / d (x, y) = [xx xy; xy yy] is symmetric; where it is not positive
// definite, the image is folded.
template <>
struct Model<CameraModel::radial_tangential> : DefaultModel {
  static constexpr std::size_t parameter_count = 5;
  static constexpr bool is_depth_along_z = true;

  template <class Number>
  [[gnu::always_inline]] static Image<Number> project(const Lens& lens, const PointOf<Number>& p) {
    const double* const k = lens.parameters;
    const Number zero(0.0);
    const Number inverse_z = Number(1.0) / p.z;
    const Number x = p.x * inverse_z;
    const Number y = p.y * inverse_z;
    const Number rho = x * x + y * y;
    const Number radial = Number(1.0) + rho * (Number(k[0]) + rho * (Number(k[1]) + rho * Number(k[4])));
    const Number slope = Number(2 * k[0]) + rho * (Number(4 * k[1]) + rho * Number(6 * k[4]));
    const Number along_x = Number(2 * k[2]) * y;
    const Number along_y = Number(2 * k[3]) * x;
    const Number xx = radial + x * x * slope + along_x + Number(3.0) * along_y;
    const Number xy = x * y * slope + Number(2 * k[2]) * x + Number(2 * k[3]) * y;
    const Number yy = radial + y * y * slope + Number(3.0) * along_x + along_y;
    const ConditionOf<Number> exists = (p.z > zero) & (xx + yy > zero) & (xx * yy - xy * xy > zero);
    return {x * radial + x * along_x + Number(k[3]) * (rho + Number(2.0) * x * x),
            y * radial + y * along_y + Number(k[2]) * (rho + Number(2.0) * y * y),
            {xx * inverse_z, xy * inverse_z, negated((xx * x + xy * y) * inverse_z)},
            {xy * inverse_z, yy * inverse_z, negated((xy * x + yy * y) * inverse_z)},
            exists};
  }
};

}  // namespace
}  // namespace maxlogdet::simd
