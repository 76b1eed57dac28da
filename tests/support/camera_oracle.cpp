// SPDX-License-Identifier: MIT
#include "tests/support/camera_oracle.hpp"

#include <cmath>
#include <iterator>

namespace maxlogdet::test {
namespace {

WideVector2 radial_tangential(const double* k, const WideVector2& m) {
  const long double x = m.x(), y = m.y(), r2 = m.squaredNorm();
  const long double radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
  return radial * m +
         WideVector2(2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y);
}

WideVector2 kannala_brandt(const double* k, const WideVector3& p) {
  const long double theta = std::atan2(std::hypot(p.x(), p.y()), p.z());
  const long double psi = std::atan2(p.y(), p.x());
  long double d = theta;
  for (int i = 0; i < 4; ++i) d += k[i] * std::pow(theta, 2 * i + 3);
  return d * WideVector2(std::cos(psi), std::sin(psi));
}

WideVector2 on_unit_plane(const Camera& camera, const WideVector3& p) {
  const double* const k = camera.parameters;
  switch (camera.model) {
    case CameraModel::pinhole: return p.head<2>() / p.z();
    case CameraModel::radial_tangential: return radial_tangential(k, p.head<2>() / p.z());
    case CameraModel::kannala_brandt: return kannala_brandt(k, p);
  }
  ADD_FAILURE() << "no oracle for this model";
  return {};
}

}  // namespace

WideVector2 image_of(const Camera& camera, const WideVector3& p) {
  const WideVector2 m = on_unit_plane(camera, p);
  return {camera.pinhole.fx * m.x() + camera.pinhole.cx, camera.pinhole.fy * m.y() + camera.pinhole.cy};
}

Camera random_camera(Random& random, CameraModel model) {
  const PinholeCamera pinhole{random.uniform(200, 800), random.uniform(200, 800), 320, 240, random.uniform(20, 400)};
  const auto around_zero = [&](double largest) { return random.uniform(-largest, largest); };
  switch (model) {
    case CameraModel::pinhole: break;
    case CameraModel::radial_tangential:
      return Camera::radial_tangential(pinhole, around_zero(0.3), around_zero(0.1), around_zero(1e-3),
                                       around_zero(1e-3), around_zero(0.03));
    case CameraModel::kannala_brandt:
      return Camera::kannala_brandt(pinhole, around_zero(0.05), around_zero(0.01), around_zero(2e-3),
                                    around_zero(3e-4));
  }
  return pinhole;
}

CameraModel random_model(Random& random) {
  return camera_models[random.integer(0, static_cast<int>(std::size(camera_models)) - 1)];
}

WideVector3 random_direction(Random& random) {
  const double z = random.uniform(-1, 1);
  const double angle = random.uniform(-3.14, 3.14);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

WideIsometry random_isometry(Random& random) {
  WideIsometry T(Eigen::AngleAxis<long double>(random.uniform(-3, 3), random_direction(random)));
  T.translation() = 2 * random_direction(random);
  return T;
}

WideVector3 random_point(Random& random, const Camera& camera) {
  const bool is_narrow = camera.model == CameraModel::pinhole || camera.model == CameraModel::radial_tangential;
  for (;;) {
    double angle = random.uniform(0, is_narrow ? 0.9 : 2);
    if (random.chance(0.2)) angle = std::pow(10, random.uniform(-9, -1));
    const double psi = random.uniform(-3.14, 3.14);
    const WideVector3 direction(std::sin(angle) * std::cos(psi), std::sin(angle) * std::sin(psi), std::cos(angle));
    const WideVector3 p = direction * random.uniform(0.5, 40);
    const double p_c[3] = {static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z())};
    double uv[2];
    if (project(camera, p_c, uv)) return p;
  }
}

}  // namespace maxlogdet::test
