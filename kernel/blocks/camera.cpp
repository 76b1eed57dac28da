// SPDX-License-Identifier: MIT
#include <maxlogdet/camera.hpp>

#include "kernel/blocks/block_checks.hpp"
#include "kernel/blocks/camera_checks.hpp"
#include "simd/jacobian.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace maxlogdet {
namespace {

constexpr std::size_t max_parameters = sizeof Camera::parameters / sizeof(double);
constexpr std::size_t model_count = sizeof camera_models / sizeof camera_models[0];

constexpr bool are_in_order() noexcept {
  for (std::size_t i = 0; i < model_count; ++i) {
    if (camera_models[i] != static_cast<CameraModel>(i)) return false;
  }
  return true;
}
static_assert(are_in_order(), "MAXLOGDET_CAMERA_MODELS lists all models in the order of the enumerators");
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

Camera Camera::double_sphere(const PinholeCamera& pinhole, double xi, double alpha) noexcept {
  return distorted(CameraModel::double_sphere, pinhole, {xi, alpha, 0, 0, 0});
}

bool has_valid_parameters(const Camera& camera) noexcept {
  const PinholeCamera& pinhole = camera.pinhole;
  const double* const k = camera.parameters;
  if (!is_positive(pinhole.fx) || !is_positive(pinhole.fy)) return false;
  if (!std::isfinite(pinhole.cx) || !std::isfinite(pinhole.cy)) return false;
  if (!all_finite(k, parameter_count(camera.model))) return false;
  return simd::with_model(camera.model, [k](auto model) { return decltype(model)::are_valid(k); });
}

simd::CameraInput camera_input(const Camera& camera) noexcept {
  const double* const k = camera.parameters;
  return simd::with_model(camera.model, [&](auto model) {
    using Model = decltype(model);
    const PinholeCamera& pinhole = camera.pinhole;
    const simd::Lens lens{k, Model::prepare(k)};
    const double* const T_cb = is_identity(camera.T_cb) ? nullptr : camera.T_cb.data();
    return simd::CameraInput{
        camera.model, Model::is_depth_along_z, pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy, pinhole.bf, lens, T_cb};
  });
}

bool project(const Camera& camera, const double* p_c, double* uv) noexcept {
  double jacobian[6];
  return project(camera, p_c, uv, jacobian);
}

bool project(const Camera& camera, const double* p_c, double* uv, double* jacobian) noexcept {
  if (!is_known(camera.model) || !has_valid_parameters(camera)) return false;
  const simd::CameraInput input = camera_input(camera);
  const simd::PointOf<double> p = {p_c[0], p_c[1], p_c[2]};
  const simd::Image<double> image = simd::project(input, p);
  double rows[2][3];
  if (!simd::image_jacobian(input, image, rows)) return false;
  const double written[8] = {input.fx * image.m_x + input.cx,
                             input.fy * image.m_y + input.cy,
                             rows[0][0],
                             rows[0][1],
                             rows[0][2],
                             rows[1][0],
                             rows[1][1],
                             rows[1][2]};
  if (!all_finite(p_c, 3) || !all_finite(written, 8)) return false;
  std::copy_n(written, 2, uv);
  std::copy_n(written + 2, 6, jacobian);
  return true;
}

const char* to_string(CameraModel model) noexcept {
#define MAXLOGDET_CASE(name) \
  case CameraModel::name: return #name;
  switch (model) { MAXLOGDET_CAMERA_MODELS(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return "unknown";
}

}  // namespace maxlogdet
