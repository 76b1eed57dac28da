// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>

#include <cmath>
#include <cstddef>
#include <limits>

// A camera model is a specialisation Model<CameraModel::NAME> with
//
//     static constexpr std::size_t parameter_count        of Camera::parameters
//     static Image<Number> project(parameters, p)         for a double and for a pack of them
//
// `project` takes + - * /, sqrt, abs, select, negated, is_finite and angle_to_axis alone, so that images are the same
// bits on every instruction set; `exists` is false where anything overflows. Internal linkage: a weak symbol would let
// the linker run wide code on a narrow machine.

namespace maxlogdet::simd {

/// A camera on the body that the pose is of.
struct CameraInput {
  CameraModel model;
  double fx, fy, cx, cy, bf;
  const double* parameters;  ///< of the model
  const double* T_cb;        ///< 3 x 4 row-major; nullptr: I, the camera is its own body
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

template <CameraModel model>
struct Model;

// The angle between (r, z), r >= 0, and the z axis, norm = sqrt(r^2 + z^2): three times
//     tan(a / 2) = tan a / (1 + sqrt(1 + tan^2 a)),
// then atan t = t - t^3 / 3 + ..., t <= tan(pi / 16), so that the terms left out are below 1e-17 of it.
template <class Number>
inline Number angle_to_axis(const Number& r, const Number& z, const Number& norm) {
  constexpr double pi = 3.14159265358979324;
  const Number one(1.0);
  Number t = r / (norm + abs(z));
  t = t / (one + sqrt(one + t * t));
  t = t / (one + sqrt(one + t * t));
  const Number square = negated(t * t);
  Number sum(1.0 / 23);
  for (int n = 21; n > 0; n -= 2) sum = sum * square + Number(1.0 / n);
  const Number angle = Number(8.0) * t * sum;
  return select(z < Number(0.0), Number(pi) - angle, angle);
}

template <>
struct Model<CameraModel::pinhole> {
  static constexpr std::size_t parameter_count = 0;

  template <class Number>
  [[gnu::always_inline]] static Image<Number> project(const double* /*parameters*/, const PointOf<Number>& p) {
    const Number zero(0.0);
    const Number inverse_z = Number(1.0) / p.z;
    return {p.x * inverse_z,
            p.y * inverse_z,
            {inverse_z, zero, negated(p.x * inverse_z * inverse_z)},
            {zero, inverse_z, negated(p.y * inverse_z * inverse_z)},
            p.z > zero};
  }
};

// With x = X / Z, y = Y / Z, G = d (m_x, m_y) / d (x, y) = [xx xy; xy yy] is symmetric; where it is not positive
// definite, the image is folded.
template <>
struct Model<CameraModel::radial_tangential> {
  static constexpr std::size_t parameter_count = 5;

  template <class Number>
  [[gnu::always_inline]] static Image<Number> project(const double* k, const PointOf<Number>& p) {
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

// m = d (X, Y) / r: along the radius it changes by d' / R, across it by d / r.
template <>
struct Model<CameraModel::kannala_brandt> {
  static constexpr std::size_t parameter_count = 4;

  template <class Number>
  [[gnu::always_inline]] static Image<Number> project(const double* k, const PointOf<Number>& p) {
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

/// visitor(Model<model>()); the model is one of the enumerators.
template <class Visitor>
[[gnu::always_inline]] inline auto with_model(CameraModel model, const Visitor& visitor) {
#define MAXLOGDET_CASE(name) \
  case CameraModel::name: return visitor(Model<CameraModel::name>());
  switch (model) { MAXLOGDET_CAMERA_MODELS(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return visitor(Model<CameraModel::pinhole>());
}

/// The image of p_c in the frame of that camera.
template <class Number>
[[gnu::always_inline]] inline Image<Number> project(const CameraInput& camera, const PointOf<Number>& p) {
  return with_model(
      camera.model, [&](auto model)
                        __attribute__((always_inline)) { return decltype(model)::project(camera.parameters, p); });
}

/// The rows of u and v of J = d z / d p_c.
template <class Number>
inline void set_image_rows(const CameraInput& camera, const Image<Number>& image, Number (*J)[3]) {
  for (int j = 0; j < 3; ++j) {
    J[0][j] = Number(camera.fx) * image.x[j];
    J[1][j] = Number(camera.fy) * image.y[j];
  }
}

}  // namespace
}  // namespace maxlogdet::simd
