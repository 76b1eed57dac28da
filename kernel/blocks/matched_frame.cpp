// SPDX-License-Identifier: MIT
#include "kernel/blocks/matched_frame.hpp"

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

Error check(const Camera& camera, DepthCue third) noexcept {
  if (!is_known(camera.model)) return Error::unknown_camera_model;
  const PinholeCamera& pinhole = camera.pinhole;
  const bool has_stereo =
      camera.model == CameraModel::pinhole && is_positive(pinhole.bf) && std::isfinite(pinhole.shift_of_right);
  const bool are_valid = is_positive(pinhole.fx) && is_positive(pinhole.fy) && std::isfinite(pinhole.cx) &&
                         std::isfinite(pinhole.cy) && all_finite(camera.parameters, parameter_count(camera.model));
  if (!are_valid || (third == DepthCue::stereo && !has_stereo)) return Error::invalid_camera;
  return is_rigid(camera.T_cb) ? Error::none : Error::invalid_pose;
}

Error check(const MatchedFrame& frame) noexcept {
  if (frame.has_mixed_cues) return Error::mixed_depth_cues;
  if (frame.cameras == nullptr || frame.camera_count == 0 || frame.camera_count > max_cameras)
    return Error::invalid_camera;
  for (std::size_t i = 0; i < frame.camera_count; ++i) {
    const Error error = check(frame.cameras[i], frame.depth_cue);
    if (error != Error::none) return error;
  }
  if (frame.size > 0 && frame.matches == nullptr) return Error::missing_matches;
  const BlockOptions& options = frame.options;
  if (!is_positive(options.depth_sigma) || !(options.map_sigma >= 0) || !std::isfinite(options.map_sigma))
    return Error::invalid_block_options;
  return is_rigid(frame.T_bw) ? Error::none : Error::invalid_pose;
}

}  // namespace maxlogdet
