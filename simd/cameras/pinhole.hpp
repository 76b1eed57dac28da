// SPDX-License-Identifier: MIT
#pragma once

#include "simd/cameras/model.hpp"

namespace maxlogdet::simd {
namespace {

template <>
struct Model<CameraModel::pinhole> : DefaultModel {
  static constexpr std::size_t parameter_count = 0;
  static constexpr bool is_depth_along_z = true;

  template <class Number>
  [[gnu::always_inline]] static Image<Number> project(const Lens& /*lens*/, const PointOf<Number>& p) {
    const Number zero(0.0);
    const Number inverse_z = Number(1.0) / p.z;
    return {p.x * inverse_z,
            p.y * inverse_z,
            {inverse_z, zero, negated(p.x * inverse_z * inverse_z)},
            {zero, inverse_z, negated(p.y * inverse_z * inverse_z)},
            p.z > zero};
  }
};

}  // namespace
}  // namespace maxlogdet::simd
