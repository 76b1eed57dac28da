// SPDX-License-Identifier: MIT
#include "kernel/blocks/block_checks.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/camera_checks.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

constexpr double rotation_tolerance = 1e-3;  // of rotation_error(): accepts poses stored in float32

}  // namespace

double RigidTransform::rotation_error() const noexcept {
  if (!all_finite(entries_, 12)) return infinity;
  double error = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double* const a = entries_ + 4 * i;
      const double* const b = entries_ + 4 * j;
      error = std::max(error, std::abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] - (i == j ? 1 : 0)));
    }
  }
  return error;
}

bool is_rigid(const RigidTransform& transform) noexcept {
  const double* const r = transform.data();
  const double determinant =
      r[0] * (r[5] * r[10] - r[6] * r[9]) - r[1] * (r[4] * r[10] - r[6] * r[8]) + r[2] * (r[4] * r[9] - r[5] * r[8]);
  return transform.rotation_error() <= rotation_tolerance && determinant > 0;
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
  const bool has_stereo = camera.model == CameraModel::pinhole && is_positive(camera.pinhole.bf) &&
                          std::isfinite(camera.pinhole.shift_of_right);
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
