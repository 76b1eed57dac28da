// SPDX-License-Identifier: MIT
#include "kernel/blocks/matched_frame.hpp"

namespace maxlogdet {
namespace {

constexpr double rotation_tolerance = 1e-3;  // of rotation_error(): accepts poses stored in float32

constexpr std::size_t max_parameters = sizeof Camera::parameters / sizeof(double);
constexpr std::size_t model_count = sizeof camera_models / sizeof camera_models[0];

#define MAXLOGDET_ASSERT(name)                                                     \
  static_assert(simd::Model<CameraModel::name>::parameter_count <= max_parameters, \
                "Camera::parameters holds those of " #name);
MAXLOGDET_CAMERA_MODELS(MAXLOGDET_ASSERT)
#undef MAXLOGDET_ASSERT

Camera distorted(CameraModel model, const PinholeCamera& pinhole, const double (&parameters)[max_parameters]) noexcept {
  Camera camera(pinhole);
  camera.model = model;
  std::copy_n(parameters, max_parameters, camera.parameters);
  return camera;
}

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

bool is_known(CameraModel model) noexcept {
  return static_cast<int>(model) >= 0 && static_cast<std::size_t>(model) < model_count;
}

std::size_t parameter_count(CameraModel model) noexcept {
  if (!is_known(model)) return 0;
  return simd::with_model(model, [](auto known) { return decltype(known)::parameter_count; });
}

Camera Camera::radial_tangential(const PinholeCamera& pinhole, double k1, double k2, double p1, double p2,
                                 double k3) noexcept {
  return distorted(CameraModel::radial_tangential, pinhole, {k1, k2, p1, p2, k3});
}

Camera Camera::kannala_brandt(const PinholeCamera& pinhole, double k1, double k2, double k3, double k4) noexcept {
  return distorted(CameraModel::kannala_brandt, pinhole, {k1, k2, k3, k4, 0});
}

simd::CameraInput camera_input(const Camera& camera) noexcept {
  const PinholeCamera& pinhole = camera.pinhole;
  const double* const T_cb = is_identity(camera.T_cb) ? nullptr : camera.T_cb.data();
  return {camera.model, pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy, pinhole.bf, camera.parameters, T_cb};
}

bool project(const Camera& camera, const double* p_c, double* uv, double* jacobian) noexcept {
  Camera alone = camera;
  alone.T_cb = RigidTransform::identity();
  if (check(alone, DepthCue::none) != Error::none || !all_finite(p_c, 3)) return false;
  const simd::CameraInput input = camera_input(alone);
  const simd::Image<double> image = simd::project(input, simd::PointOf<double>{p_c[0], p_c[1], p_c[2]});
  double rows[2][3];
  simd::set_image_rows(input, image, rows);
  const double written[2] = {input.fx * image.m_x + input.cx, input.fy * image.m_y + input.cy};
  if (!image.exists || !all_finite(written, 2) || !all_finite(rows[0], 3) || !all_finite(rows[1], 3)) return false;
  std::copy_n(written, 2, uv);
  for (int e = 0; e < 6 && jacobian != nullptr; ++e) jacobian[e] = rows[e / 3][e % 3];
  return true;
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
