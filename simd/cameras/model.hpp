// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera_model.hpp>

#include <cmath>
#include <cstddef>
#include <limits>

// A camera model is a specialisation Model<CameraModel::NAME> in simd/cameras/NAME.hpp, derived from DefaultModel, with
//
//     static constexpr std::size_t parameter_count        of Camera::parameters
//     static constexpr bool is_depth_along_z              whether min_depth bounds Z, or else |p_c|
//     static Image<Number> project(lens, p)               for a double and for a pack of them
//
// and, unless the defaults suit it, are_valid and prepare. `project` takes + - * /, sqrt, abs, select, negated,
// is_finite and angle_to_axis (angle.hpp) alone, so that images are the same bits on every instruction set; `exists` is
// false where anything overflows. `prepare`, which runs once per camera, may use the C library. Internal linkage: a
// weak symbol would let the linker run wide code on a narrow machine.

namespace maxlogdet::simd {

/// The parameters of a camera, and what Model::prepare makes of them, once per camera.
struct Lens {
  const double* parameters;
  double prepared;
};

namespace {

/// A point, in the camera frame or another; Number is double or a pack of doubles.
template <class Number>
struct PointOf {
  Number x, y, z;
};

/// bool, or a mask with one condition per lane.
template <class Number>
using ConditionOf = decltype(Number(0.0) > Number(0.0));

/// The image m of a point, u = fx m_x + cx, v = fy m_y + cy, d m / d p_c, and where the model has an image.
template <class Number>
struct Image {
  Number m_x, m_y;
  Number x[3], y[3];  // d m_x / d p_c, d m_y / d p_c
  ConditionOf<Number> exists;
};

using std::abs;
using std::sqrt;

inline double select(bool condition, double yes, double no) { return condition ? yes : no; }

template <class Number>
inline Number negated(const Number& value) {
  return Number(-0.0) - value;
}

template <class Number>
inline ConditionOf<Number> is_finite(const Number& value) {
  return abs(value) <= Number(std::numeric_limits<double>::max());
}

struct DefaultModel {
  /// Of finite parameters.
  static bool are_valid(const double* /*parameters*/) { return true; }
  static double prepare(const double* /*parameters*/) { return 0; }
};

template <CameraModel model>
struct Model;

}  // namespace
}  // namespace maxlogdet::simd
