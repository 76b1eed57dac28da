// SPDX-License-Identifier: MIT
#include <maxlogdet/point_covariance.hpp>

#include "kernel/blocks/matched_frame.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

// The information assumed in every direction, as a share of the total: a depth that no observation has told leaves
// whitening its digits (docs/numerics.md).
constexpr double unknown_share = 1e-8;

double trace_of(const double* information) noexcept { return information[0] + information[4] + information[8]; }

// Adds a row of J R_cw, given that of J.
void add_row(const double* T, double x, double y, double z, double* information) noexcept {
  double row[3];
  for (int i = 0; i < 3; ++i) row[i] = x * T[i] + y * T[4 + i] + z * T[8 + i];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) information[3 * i + j] += row[i] * row[j];
  }
}

}  // namespace

void PointCovariance::observe(const PinholeCamera& camera, const RigidTransform& T_cw, double sigma,
                              bool is_stereo) noexcept {
  const double* const T = T_cw.data();
  double p[3];
  T_cw.transform(p_w_.xyz, p);
  if (!(p[2] > 0) || !all_finite(p, 3) || !is_positive(sigma)) return;
  if (check(camera, DepthCue::none) != Error::none || (is_stereo && !std::isfinite(camera.bf))) return;
  const double x = p[0] / p[2];
  const double y = p[1] / p[2];
  const double weight = 1 / (p[2] * sigma);
  double sum[9];
  std::copy_n(information_, 9, sum);
  add_row(T, camera.fx * weight, 0, -camera.fx * x * weight, sum);
  add_row(T, 0, camera.fy * weight, -camera.fy * y * weight, sum);
  if (is_stereo && camera.bf > 0) add_row(T, camera.fx * weight, 0, (camera.bf / p[2] - camera.fx * x) * weight, sum);
  if (std::isfinite(trace_of(sum))) std::copy_n(sum, 9, information_);
}

bool PointCovariance::covariance(double* entries) const noexcept {
  double a[3][3];
  const double trace = trace_of(information_);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) a[i][j] = information_[3 * i + j] + (i == j ? unknown_share * trace : 0);
  }
  const double cofactors[3] = {a[1][1] * a[2][2] - a[1][2] * a[2][1], a[1][2] * a[2][0] - a[1][0] * a[2][2],
                               a[1][0] * a[2][1] - a[1][1] * a[2][0]};
  const double determinant = a[0][0] * cofactors[0] + a[0][1] * cofactors[1] + a[0][2] * cofactors[2];
  if (!(determinant > 0) || !(determinant < 1e300)) return false;  // 0 without an observation
  const double inverse = 1 / determinant;
  const double xx = cofactors[0] * inverse;
  const double xy = cofactors[1] * inverse;
  const double xz = cofactors[2] * inverse;
  const double yy = (a[0][0] * a[2][2] - a[0][2] * a[2][0]) * inverse;
  const double yz = (a[0][2] * a[1][0] - a[0][0] * a[1][2]) * inverse;
  const double zz = (a[0][0] * a[1][1] - a[0][1] * a[1][0]) * inverse;
  const double all[9] = {xx, xy, xz, xy, yy, yz, xz, yz, zz};
  if (!all_finite(all, 9)) return false;
  std::copy_n(all, 9, entries);
  return true;
}

}  // namespace maxlogdet
