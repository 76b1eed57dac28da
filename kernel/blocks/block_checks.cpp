// SPDX-License-Identifier: MIT
#include "kernel/blocks/block_checks.hpp"

#include "kernel/blocks/camera_checks.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

constexpr double rotation_tolerance = 1e-3;  // on entries of R R^T - I: accepts poses stored in float32

}  // namespace

bool is_rigid(const RigidTransform& transform) noexcept {
  const double* const T_cw = transform.data();
  if (!all_finite(T_cw, 12)) return false;
  double r[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r[i][j] = T_cw[4 * i + j];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double dot = r[i][0] * r[j][0] + r[i][1] * r[j][1] + r[i][2] * r[j][2];
      if (std::abs(dot - (i == j ? 1 : 0)) > rotation_tolerance) return false;
    }
  }
  const double determinant = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                             r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                             r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
  return determinant > 0;
}

bool is_identity(const RigidTransform& transform) noexcept {
  return std::equal(transform.data(), transform.data() + 12, RigidTransform::identity().data());
}

Error check(const Points& points, std::size_t size) noexcept {
  if (size == 0) return Error::none;
  if (points.data() == nullptr) return Error::missing_points;
  const std::size_t entry = points.are_float() ? sizeof(float) : sizeof(double);
  const bool is_stride = points.stride() >= 3 * entry && points.stride() % entry == 0;
  return is_stride ? Error::none : Error::invalid_stride;
}

Error check(const BlockOptions& options) noexcept {
  const bool are_in_range = is_positive(options.depth_sigma) && options.map_sigma >= 0 &&
                            std::isfinite(options.map_sigma) && options.min_depth >= 0 &&
                            std::isfinite(options.min_depth);
  const bool are_known = options.weighting >= Weighting::map_bias &&
                         options.weighting <= Weighting::measurement_and_map && options.depth_cue >= DepthCue::none &&
                         options.depth_cue <= DepthCue::depth;
  return are_in_range && are_known ? Error::none : Error::invalid_block_options;
}

Error check(const Camera& camera, DepthCue third) noexcept {
  if (!is_known(camera.model)) return Error::unknown_camera_model;
  const bool has_stereo = camera.model == CameraModel::pinhole && is_positive(camera.pinhole.bf);
  if (third == DepthCue::stereo && !has_stereo) return Error::invalid_camera;
  if (!has_valid_parameters(camera)) return Error::invalid_camera;
  return is_rigid(camera.T_cb) ? Error::none : Error::invalid_pose;
}

Error check(const Camera* cameras, std::size_t count, DepthCue third) noexcept {
  if (cameras == nullptr || count == 0 || count > max_cameras) return Error::invalid_camera;
  for (std::size_t i = 0; i < count; ++i) {
    const Error error = check(cameras[i], third);
    if (error != Error::none) return error;
  }
  return Error::none;
}

Error check(const Camera* cameras, std::size_t count, const BlockOptions& options,
            const RigidTransform& T_bw) noexcept {
  Error error = check(cameras, count, options.depth_cue);
  if (error == Error::none) error = check(options);
  return error == Error::none && !is_rigid(T_bw) ? Error::invalid_pose : error;
}

}  // namespace maxlogdet
