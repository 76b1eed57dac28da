// SPDX-License-Identifier: MIT
#pragma once

#include "simd/cameras/double_sphere.hpp"
#include "simd/cameras/kannala_brandt.hpp"
#include "simd/cameras/pinhole.hpp"
#include "simd/cameras/radial_tangential.hpp"

namespace maxlogdet::simd {
namespace {

/// visitor(Model<model>()); the model is one of the enumerators.
template <class Visitor>
[[gnu::always_inline]] inline auto with_model(CameraModel model, const Visitor& visitor) {
#define MAXLOGDET_CASE(name) \
  case CameraModel::name: return visitor(Model<CameraModel::name>());
  switch (model) { MAXLOGDET_CAMERA_MODELS(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return visitor(Model<CameraModel::pinhole>());
}

}  // namespace
}  // namespace maxlogdet::simd
