// SPDX-License-Identifier: MIT
#include <maxlogdet/camera.hpp>

#include "kernel/blocks/camera_checks.hpp"

#include <cmath>
#include <cstddef>

namespace maxlogdet {
namespace {

constexpr std::size_t max_parameters = sizeof Camera::parameters / sizeof(double);

Camera distorted(CameraModel model, const PinholeCamera& pinhole, const double (&parameters)[max_parameters]) noexcept {
  Camera camera(pinhole);
  camera.model = model;
  for (std::size_t i = 0; i < max_parameters; ++i) camera.parameters[i] = parameters[i];
  return camera;
}

// (m_x, m_y), u = fx m_x + cx, v = fy m_y + cy, and d (m_x, m_y) / d p_c by rows.
struct Image {
  double m[2];
  double by_point[2][3];
};

// Each of these says whether there is an image.

bool see_pinhole(const double* p, Image& image) noexcept {
  const double inverse = 1 / p[2];
  const double x = p[0] * inverse;
  const double y = p[1] * inverse;
  image = {{p[0] / p[2], p[1] / p[2]}, {{inverse, 0, -x * inverse}, {0, inverse, -y * inverse}}};
  return p[2] > 0;
}

bool see_radial_tangential(const double* k, const double* p, Image& image) noexcept {
  const double x = p[0] / p[2];
  const double y = p[1] / p[2];
  const double inverse = 1 / p[2];
  const double rho = x * x + y * y;
  const double radial = 1 + rho * (k[0] + rho * (k[1] + rho * k[4]));
  const double slope = 2 * k[0] + rho * (4 * k[1] + rho * 6 * k[4]);
  const double xx = radial + x * x * slope + 2 * k[2] * y + 6 * k[3] * x;
  const double xy = x * y * slope + 2 * k[2] * x + 2 * k[3] * y;
  const double yy = radial + y * y * slope + 6 * k[2] * y + 2 * k[3] * x;
  image = {{x * radial + 2 * k[2] * x * y + k[3] * (rho + 2 * x * x),
            y * radial + k[2] * (rho + 2 * y * y) + 2 * k[3] * x * y},
           {{xx * inverse, xy * inverse, -(xx * x + xy * y) * inverse},
            {xy * inverse, yy * inverse, -(xy * x + yy * y) * inverse}}};
  return p[2] > 0 && xx + yy > 0 && xx * yy - xy * xy > 0;
}

// Along the radius the image changes by `slope` an angle, across it by d / r.
bool see_kannala_brandt(const double* k, const double* p, Image& image) noexcept {
  const double r_squared = p[0] * p[0] + p[1] * p[1];
  const double r = std::sqrt(r_squared);
  const double theta = std::atan2(r, p[2]);
  const double q = theta * theta;
  const double d = theta * (1 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3]))));
  const double slope = 1 + q * (3 * k[0] + q * (5 * k[1] + q * (7 * k[2] + q * 9 * k[3])));
  const double across = r > 0 ? d / r : 1 / p[2];
  const double x = r > 0 ? p[0] / r : 0;
  const double y = r > 0 ? p[1] / r : 0;
  const double by_z = slope / (r_squared + p[2] * p[2]);
  const double along = by_z * p[2] - across;
  image = {
      {across * p[0], across * p[1]},
      {{across + along * x * x, along * x * y, -by_z * p[0]}, {along * x * y, across + along * y * y, -by_z * p[1]}}};
  return std::isfinite(r) && slope > 0 && ((r > 0 && d > 0) || p[2] > 0);
}

// m = (X, Y) / divisor, d divisor = g (X dX + Y dY) + h dZ.
bool see_double_sphere(const Camera& camera, const double* p, Image& image) noexcept {
  const double xi = camera.parameters[0];
  const double alpha = camera.parameters[1];
  const double r_squared = p[0] * p[0] + p[1] * p[1];
  const double d1 = std::sqrt(r_squared + p[2] * p[2]);
  const double k = xi * d1 + p[2];
  const double d2 = std::sqrt(r_squared + k * k);
  const double divisor = alpha * d2 + (1 - alpha) * k;
  const double g = alpha / d2 * (1 + k * xi / d1) + (1 - alpha) * xi / d1;
  const double h = (xi * p[2] / d1 + 1) * (alpha * k / d2 + 1 - alpha);
  const double x = p[0] / divisor;
  const double y = p[1] / divisor;
  image = {{x, y},
           {{(1 - g * x * p[0]) / divisor, -g * x * y, -h * x / divisor},
            {-g * x * y, (1 - g * y * p[1]) / divisor, -h * y / divisor}}};
  return divisor > 0 && p[2] > min_cosine(camera) * d1 && (divisor - g * r_squared) * p[2] + h * r_squared > 0;
}

// The model is one of the enumerators, its parameters are valid.
bool see(const Camera& camera, const double* p, Image& image) noexcept {
  switch (camera.model) {
    case CameraModel::pinhole: return see_pinhole(p, image);
    case CameraModel::radial_tangential: return see_radial_tangential(camera.parameters, p, image);
    case CameraModel::kannala_brandt: return see_kannala_brandt(camera.parameters, p, image);
    case CameraModel::double_sphere: return see_double_sphere(camera, p, image);
  }
  return false;
}

bool is_known(CameraModel model) noexcept {
  return model >= CameraModel::pinhole && model <= CameraModel::double_sphere;
}

}  // namespace

std::size_t parameter_count(CameraModel model) noexcept {
  switch (model) {
    case CameraModel::pinhole: return 0;
    case CameraModel::radial_tangential: return 5;
    case CameraModel::kannala_brandt: return 4;
    case CameraModel::double_sphere: return 2;
  }
  return 0;
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
  if (!(pinhole.fx > 0 && std::isfinite(pinhole.fx) && pinhole.fy > 0 && std::isfinite(pinhole.fy))) return false;
  for (std::size_t i = 0; i < parameter_count(camera.model); ++i) {
    if (!std::isfinite(camera.parameters[i])) return false;
  }
  const double xi = camera.parameters[0];
  const double alpha = camera.parameters[1];
  return camera.model != CameraModel::double_sphere || (xi > -1 && alpha >= 0 && alpha <= 1);
}

double min_cosine(const Camera& camera) noexcept {
  const double xi = camera.parameters[0];
  const double alpha = camera.parameters[1];
  const double w1 = alpha > 0.5 ? (1 - alpha) / alpha : alpha / (1 - alpha);
  return -(w1 + xi) / std::sqrt(2 * w1 * xi + xi * xi + 1);
}

bool project(const Camera& camera, const double* p_c, double* uv) noexcept {
  double jacobian[6];
  return project(camera, p_c, uv, jacobian);
}

bool project(const Camera& camera, const double* p_c, double* uv, double* jacobian) noexcept {
  if (!is_known(camera.model) || !has_valid_parameters(camera)) return false;
  Image image;
  if (!see(camera, p_c, image)) return false;
  const PinholeCamera& pinhole = camera.pinhole;
  const double u = pinhole.fx * image.m[0] + pinhole.cx;
  const double v = pinhole.fy * image.m[1] + pinhole.cy;
  if (!std::isfinite(p_c[2]) || !std::isfinite(u) || !std::isfinite(v)) return false;
  uv[0] = u;
  uv[1] = v;
  bool is_finite = true;
  for (std::size_t i = 0; i < 3; ++i) {
    jacobian[i] = pinhole.fx * image.by_point[0][i];
    jacobian[3 + i] = pinhole.fy * image.by_point[1][i];
    is_finite = is_finite && std::isfinite(jacobian[i]) && std::isfinite(jacobian[3 + i]);
  }
  return is_finite;
}

const char* to_string(CameraModel model) noexcept {
  switch (model) {
    case CameraModel::pinhole: return "pinhole";
    case CameraModel::radial_tangential: return "radial_tangential";
    case CameraModel::kannala_brandt: return "kannala_brandt";
    case CameraModel::double_sphere: return "double_sphere";
  }
  return "unknown";
}

}  // namespace maxlogdet
