// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"
#include "simd/camera_models.hpp"

// J = d z / d p of a match, p its point in the frame of the camera or of the body: of packs for blocks, of a double for
// the weight of a match. C++14, as kernel/.

namespace maxlogdet::simd {

constexpr double root_half = 0.70710678118654752;

namespace {

template <class Number>
[[gnu::always_inline]] inline Image<Number> project(const CameraInput& camera, const PointOf<Number>& p) {
  return with_model(
      camera.model, [&](auto model)
                        __attribute__((always_inline)) { return decltype(model)::project(camera.lens, p); });
}

/// The rows of u and v by p_c. Returns where the camera's model has an image.
template <class Number, int Rows>
inline ConditionOf<Number> image_jacobian(const CameraInput& camera, const Image<Number>& image,
                                          Number (&rows)[Rows][3]) {
  for (int j = 0; j < 3; ++j) {
    rows[0][j] = Number(camera.fx) * image.x[j];
    rows[1][j] = Number(camera.fy) * image.y[j];
  }
  return image.exists;
}
template <class Number, int Rows>
inline ConditionOf<Number> image_jacobian(const CameraInput& camera, const PointOf<Number>& p,
                                          Number (&rows)[Rows][3]) {
  return image_jacobian(camera, project(camera, p), rows);
}

/// The third row by p_c, zeros where there is none: that of the depth, or that of u_right, which is rotated with that
/// of u to (u + u_right, u_right - u) / sqrt(2), of which the last depends on the depth alone.
template <DepthCue third, class Number, int Rows>
inline void add_third_row(double bf, const Number& depth, const ConditionOf<Number>& has_third,
                          Number (&rows)[Rows][3]) {
  static_assert(Rows == (third == DepthCue::none ? 2 : 3), "a third row has its place");
  if (third == DepthCue::none) return;
  constexpr int last = Rows - 1;
  const Number zero(0.0);
  rows[last][0] = rows[last][1] = zero;
  if (third == DepthCue::depth) {
    rows[last][2] = select(has_third, Number(1.0), zero);
    return;
  }
  rows[last][2] = select(has_third, Number(bf * root_half) / (depth * depth), zero);
  for (Number& entry : rows[0]) entry = select(has_third, Number(2 * root_half) * entry, entry);
  rows[0][2] = rows[0][2] + rows[last][2];
}

/// rows <- rows R, R of a 3 x 4 transform: from derivatives by p_c to derivatives by p_b.
template <class Number, int Rows>
inline void rotate_to_body(const double* T_cb, Number (&rows)[Rows][3]) {
  for (auto& row : rows) {
    Number rotated[3];
    for (int j = 0; j < 3; ++j) {
      rotated[j] = row[0] * Number(T_cb[j]) + row[1] * Number(T_cb[4 + j]) + row[2] * Number(T_cb[8 + j]);
    }
    for (int j = 0; j < 3; ++j) row[j] = rotated[j];
  }
}

}  // namespace
}  // namespace maxlogdet::simd
