// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>
#include <maxlogdet/inputs.hpp>

#include <cmath>

namespace maxlogdet {

/// The covariance of a map point from the cameras that have observed it, with their poses held fixed: the inverse of
/// the information of the observations, sum of H_p^T H_p / sigma^2 with H_p = J R_cw. One stereo observation suffices;
/// a point that one camera has seen once has no depth, but a covariance, some ten thousand times as large along the ray
/// as across it.
///
///   PointCovariance point(p_w);
///   for (observation) point.observe(camera, T_cw, sigma, is_stereo);
///   if (point.covariance(covariance)) match.covariance = covariance;
class PointCovariance {
 public:
  /// Takes p_w: 3 entries, m.
  template <class Scalar>
  explicit PointCovariance(const Scalar* p_w) noexcept : p_w_{double(p_w[0]), double(p_w[1]), double(p_w[2])} {}

  /// Adds an observation by a rectified pinhole at T_cw (world to camera) with standard deviation sigma, px, with a
  /// stereo row if `is_stereo` and bf > 0. No-op for a point that is not in front of the camera, a sigma that is not
  /// positive, a camera that is not valid, and numbers that are not finite.
  void observe(const PinholeCamera& camera, const RigidTransform& T_cw, double sigma, bool is_stereo) noexcept {
    const double* const T = T_cw.data();
    double p[3];
    T_cw.transform(p_w_, p);
    const bool is_in_front = p[2] > 0 && std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    if (!is_in_front || !is_positive(sigma) || !is_valid(camera, is_stereo)) return;
    const double x = p[0] / p[2];
    const double y = p[1] / p[2];
    const double weight = 1 / (p[2] * sigma);
    Information sum = information_;
    sum.add_row(T, camera.fx * weight, 0, -camera.fx * x * weight);
    sum.add_row(T, 0, camera.fy * weight, -camera.fy * y * weight);
    if (is_stereo && camera.bf > 0) sum.add_row(T, camera.fx * weight, 0, (camera.bf / p[2] - camera.fx * x) * weight);
    if (!std::isfinite(sum.trace())) return;
    information_ = sum;
    ++observations_;
  }

  /// The number of observations added.
  int observations() const noexcept { return observations_; }

  /// Writes the covariance, 3 x 3, world frame, m^2. Returns false, and writes nothing, without an observation, or
  /// where it, or the determinant of the information, is beyond float64 (a sigma of some 1e50 px).
  bool covariance(double* entries) const noexcept {
    double a[3][3];
    const double trace = information_.trace();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) a[i][j] = information_.entries[i][j] + (i == j ? unknown_share * trace : 0);
    }
    const double cofactors[3] = {a[1][1] * a[2][2] - a[1][2] * a[2][1], a[1][2] * a[2][0] - a[1][0] * a[2][2],
                                 a[1][0] * a[2][1] - a[1][1] * a[2][0]};
    const double determinant = a[0][0] * cofactors[0] + a[0][1] * cofactors[1] + a[0][2] * cofactors[2];
    if (observations_ == 0 || !(determinant > 0) || !(determinant < 1e300)) return false;
    const double inverse = 1 / determinant;
    const double xx = cofactors[0] * inverse;
    const double xy = cofactors[1] * inverse;
    const double xz = cofactors[2] * inverse;
    const double yy = (a[0][0] * a[2][2] - a[0][2] * a[2][0]) * inverse;
    const double yz = (a[0][2] * a[1][0] - a[0][0] * a[1][2]) * inverse;
    const double zz = (a[0][0] * a[1][1] - a[0][1] * a[1][0]) * inverse;
    const double all[9] = {xx, xy, xz, xy, yy, yz, xz, yz, zz};
    for (const double entry : all) {
      if (!std::isfinite(entry)) return false;
    }
    for (int e = 0; e < 9; ++e) entries[e] = all[e];
    return true;
  }

 private:
  struct Information {
    double entries[3][3] = {};

    double trace() const noexcept { return entries[0][0] + entries[1][1] + entries[2][2]; }
    // A row of J R_cw, given that of J.
    void add_row(const double* T, double x, double y, double z) noexcept {
      double row[3];
      for (int i = 0; i < 3; ++i) row[i] = x * T[i] + y * T[4 + i] + z * T[8 + i];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) entries[i][j] += row[i] * row[j];
      }
    }
  };

  static bool is_positive(double value) noexcept { return value > 0 && std::isfinite(value); }
  static bool is_valid(const PinholeCamera& camera, bool is_stereo) noexcept {
    return is_positive(camera.fx) && is_positive(camera.fy) && std::isfinite(camera.cx) && std::isfinite(camera.cy) &&
           (!is_stereo || std::isfinite(camera.bf));
  }

  // The information assumed in every direction, as a share of the total: a depth that no observation has told leaves
  // whitening its digits (docs/numerics.md).
  static constexpr double unknown_share = 1e-8;

  double p_w_[3];
  Information information_;
  int observations_ = 0;
};

}  // namespace maxlogdet
