// SPDX-License-Identifier: MIT
#include "tests/support/plain_blocks.hpp"

#include "tests/support/linear_algebra.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace maxlogdet::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

using Pose = PinholeBatch::Pose;
using Matrix3 = PinholeBatch::Matrix3;

double broken_value(Random& random) {
  const double values[] = {nan, infinity, -infinity, -1, -0.0};
  return values[random.integer(0, 4)];
}

// append_blocks for one match, one operation after the other, each rounded to float64.

bool is_positive(double value) { return value > 0 && std::isfinite(value); }

struct Point {
  double x, y, z;
};

// The upper triangle of a symmetric matrix.
struct Symmetric {
  double xx, xy, xz, yy, yz, zz;
};

// Upper triangular: a block is A [I | -[p]x].
struct Triangle {
  double a00 = 0, a01 = 0, a02 = 0, a11 = 0, a12 = 0, a22 = 0;
};

// One match, with defaults for arrays that are not given.
struct Given {
  Point p;  // in the camera frame
  double sigma;
  bool has_depth_cue;
};

Point in_camera(const PinholeBatch& batch, std::size_t i) {
  const Eigen::Vector3d& p = batch.points[i];
  const auto coordinate = [&](int row) {
    return batch.T_cw(row, 0) * p.x() + batch.T_cw(row, 1) * p.y() + batch.T_cw(row, 2) * p.z() + batch.T_cw(row, 3);
  };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

// From coordinates along the ray, (dX - x dZ, dY - y dZ, dZ), to (dX, dY, dZ).
void from_ray(double x, double y, Triangle& a) {
  a.a02 = a.a02 - a.a00 * x - a.a01 * y;
  a.a12 = a.a12 - a.a11 * y;
}

Triangle map_bias_triangle(const Given& match) {
  const auto& [p, sigma, has_depth_cue] = match;
  Triangle a;
  a.a00 = a.a11 = 1;
  a.a02 = has_depth_cue ? 0 : -(p.x / p.z);
  a.a12 = has_depth_cue ? 0 : -(p.y / p.z);
  a.a22 = has_depth_cue ? 1 : 0;
  return a;
}

// False if a variance is zero.
bool measurement_triangle(const PinholeBatch& batch, const Given& match, Triangle& a) {
  const double root_half = std::sqrt(0.5);
  const double inverse_z = 1 / match.p.z;
  const double weight = batch.matches.sigmas == nullptr ? inverse_z : inverse_z / match.sigma;
  bool is_definite = match.sigma * match.sigma > 0;
  a.a00 = batch.camera.fx * weight;
  a.a11 = batch.camera.fy * weight;
  if (match.has_depth_cue && batch.options.depth_cue == DepthCue::stereo) {
    a.a00 = a.a00 * (2 * root_half);
    a.a02 = a.a22 = batch.camera.bf * root_half * (inverse_z * weight);
  } else if (match.has_depth_cue) {
    is_definite = is_definite && batch.options.depth_sigma * batch.options.depth_sigma > 0;
    a.a22 = 1 / batch.options.depth_sigma;
  }
  from_ray(match.p.x * inverse_z, match.p.y * inverse_z, a);
  return is_definite;
}

// R Sigma_p R^T.
Symmetric in_camera_frame(const Pose& T_cw, const Matrix3& covariance) {
  const double* const s = covariance.data();
  const double upper[3][3] = {{s[0], s[1], s[2]}, {s[1], s[4], s[5]}, {s[2], s[5], s[8]}};
  double rows[3][3];
  for (int a = 0; a < 3; ++a) {
    for (int c = 0; c < 3; ++c) {
      rows[a][c] = T_cw(a, 0) * upper[0][c] + T_cw(a, 1) * upper[1][c] + T_cw(a, 2) * upper[2][c];
    }
  }
  const auto entry = [&](int a, int b) {
    return rows[a][0] * T_cw(b, 0) + rows[a][1] * T_cw(b, 1) + rows[a][2] * T_cw(b, 2);
  };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

Symmetric along_ray(const Symmetric& s, double x, double y) {
  const double xz = s.xz - x * s.zz;
  const double yz = s.yz - y * s.zz;
  return {s.xx - x * (s.xz + xz), s.xy - y * s.xz - x * yz, xz, s.yy - y * (s.yz + yz), yz, s.zz};
}

// The covariance of the point as measured, along the ray.
Symmetric measured_along_ray(const PinholeBatch& batch, const Given& match) {
  const double variance = match.sigma * match.sigma;
  const double a = match.p.z * (1 / batch.camera.fx);
  const double b = match.p.z * (1 / batch.camera.fy);
  Symmetric s{a * a * variance, 0, 0, b * b * variance, 0, 0};
  if (batch.options.depth_cue == DepthCue::stereo) {
    const double per_pixel = match.p.z * match.p.z * (1 / batch.camera.bf);
    s.xz = -(a * per_pixel * variance);
    s.zz = per_pixel * per_pixel * (variance + variance);
  } else if (batch.options.depth_cue == DepthCue::depth) {
    s.zz = batch.options.depth_sigma * batch.options.depth_sigma;
  }
  return s;
}

// A with A^T A = S^-1, without a third measurement of the first two coordinates alone; false if S is not positive
// definite.
bool whiten(const Symmetric& s, bool has_depth_cue, Triangle& a) {
  const double inverse_zz = has_depth_cue ? 1 / std::sqrt(s.zz) : 0;
  const double xz = has_depth_cue ? s.xz * inverse_zz : 0;
  const double yz = has_depth_cue ? s.yz * inverse_zz : 0;
  const double yy = s.yy - yz * yz;
  const double inverse_yy = 1 / std::sqrt(yy);
  const double xy = (s.xy - xz * yz) * inverse_yy;
  const double xx = s.xx - xz * xz - xy * xy;
  const double inverse_xx = 1 / std::sqrt(xx);
  a.a00 = inverse_xx;
  a.a01 = -(xy * inverse_yy * inverse_xx);
  a.a11 = inverse_yy;
  a.a12 = -(yz * inverse_zz * inverse_yy);
  a.a02 = -((xz * inverse_xx + yz * a.a01) * inverse_zz);
  a.a22 = inverse_zz;
  return (!has_depth_cue || is_positive(s.zz)) && is_positive(yy) && is_positive(xx);
}

// Whether rounding leaves digits (docs/numerics.md). A is along the ray, x and y are its direction.
bool keeps_digits(const Triangle& a, double x, double y, const BlockOptions& options, const double* covariance) {
  const double of_x = 1 + std::abs(x);
  const double of_y = 1 + std::abs(y);
  const double rows[3] = {a.a00 * of_x + std::abs(a.a01) * of_y + std::abs(a.a02), a.a11 * of_y + std::abs(a.a12),
                          a.a22};
  const double norms = rows[0] * rows[0] + rows[1] * rows[1] + rows[2] * rows[2];
  double square = 3 * options.map_sigma * options.map_sigma * options.map_sigma * options.map_sigma;
  if (covariance != nullptr) {
    const double* const s = covariance;
    square = s[0] * s[0] + s[4] * s[4] + s[8] * s[8] + 2 * (s[1] * s[1] + s[2] * s[2] + s[5] * s[5]);
  }
  return square * (norms * norms) <= std::ldexp(1.0, 78);
}

bool whitened_triangle(const PinholeBatch& batch, std::size_t i, const Given& match, Triangle& a) {
  const double inverse_z = 1 / match.p.z;
  const double x = match.p.x * inverse_z;
  const double y = match.p.y * inverse_z;
  const Symmetric measured = measured_along_ray(batch, match);
  const double variance = batch.options.map_sigma * batch.options.map_sigma;
  const Symmetric mapped = batch.matches.map_covariances == nullptr
                               ? Symmetric{variance, 0, 0, variance, 0, variance}
                               : in_camera_frame(batch.T_cw, batch.map_covariances[i]);
  const Symmetric map = along_ray(mapped, x, y);
  const Symmetric s{measured.xx + map.xx, measured.xy + map.xy, measured.xz + map.xz,
                    measured.yy + map.yy, measured.yz + map.yz, measured.zz + map.zz};
  const bool is_definite = whiten(s, match.has_depth_cue, a);
  const bool has_covariance = batch.matches.map_covariances != nullptr;
  const bool is_sound =
      keeps_digits(a, x, y, batch.options, has_covariance ? batch.map_covariances[i].data() : nullptr);
  from_ray(x, y, a);
  const bool has_depth = match.has_depth_cue && batch.options.depth_cue == DepthCue::depth;
  const bool has_variances =
      match.sigma * match.sigma > 0 && (!has_depth || batch.options.depth_sigma * batch.options.depth_sigma > 0);
  return is_definite && is_sound && has_variances;
}

using Rows = double[3][6];

void multiply_by_point_jacobian(const Triangle& a, const Point& p, Rows& h) {
  const Rows product = {
      {a.a00, a.a01, a.a02, a.a02 * p.y - a.a01 * p.z, a.a00 * p.z - a.a02 * p.x, a.a01 * p.x - a.a00 * p.y},
      {0, a.a11, a.a12, a.a12 * p.y - a.a11 * p.z, -(a.a12 * p.x), a.a11 * p.x},
      {0, 0, a.a22, a.a22 * p.y, -(a.a22 * p.x), 0}};
  std::memcpy(h, product, sizeof h);
}

// False if the ray is orthogonal to the world's z axis.
bool map_bias_world_rows(const Pose& T_cw, const Given& match, Rows& h) {
  const Point& p = match.p;
  const double share = T_cw(0, 2) * p.x + T_cw(1, 2) * p.y + T_cw(2, 2) * p.z;
  const double norm = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  for (int i = 0; i < 3; ++i) {
    const double projected = T_cw(0, i) * p.x + T_cw(1, i) * p.y + T_cw(2, i) * p.z;
    double b[3];
    for (int j = 0; j < 3; ++j) b[j] = T_cw(j, i) - projected * (match.has_depth_cue ? 0 : T_cw(j, 2) / share);
    const double row[6] = {b[0], b[1], b[2], b[2] * p.y - b[1] * p.z, b[0] * p.z - b[2] * p.x, b[1] * p.x - b[0] * p.y};
    std::copy_n(row, 6, h[i]);
  }
  return match.has_depth_cue || !(std::abs(share) < 1e-6 * norm);
}

// False if there is no block, or float32 cannot hold it.
bool has_block(const PinholeBatch& batch, std::size_t i, const Given& match, ExpectedBlock& expected) {
  Rows h = {};
  Triangle a;
  bool is_definite = true;
  switch (batch.options.weighting) {
    case Weighting::map_bias: a = map_bias_triangle(match); break;
    case Weighting::measurement: is_definite = measurement_triangle(batch, match, a); break;
    case Weighting::measurement_and_map: is_definite = whitened_triangle(batch, i, match, a); break;
    case Weighting::map_bias_world: is_definite = map_bias_world_rows(batch.T_cw, match, h);
  }
  if (batch.options.weighting != Weighting::map_bias_world) multiply_by_point_jacobian(a, match.p, h);
  bool is_held = true;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 6; ++column) {
      expected.entries[row][column] = static_cast<float>(h[row][column]);
      is_held = is_held && std::isfinite(expected.entries[row][column]);
    }
  }
  const bool is_world = batch.options.weighting == Weighting::map_bias_world;
  if (!is_definite) expected.reason = is_world ? &BlockReport::singular_rays : &BlockReport::invalid_covariances;
  return is_definite && is_held;
}

}  // namespace

PinholeBatch random_batch(Random& random, std::size_t n, Weighting weighting, DepthCue depth_cue) {
  PinholeBatch batch;
  batch.camera = {random.uniform(300, 800), random.uniform(300, 800), 320, 240, random.uniform(20, 400)};
  const Eigen::Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  const Eigen::Matrix3d R = Eigen::AngleAxisd(random.uniform(-3, 3), axis.normalized()).toRotationMatrix();
  const Eigen::Vector3d t(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
  batch.T_cw << R, t;
  batch.options.weighting = weighting;
  batch.options.depth_cue = depth_cue;
  batch.options.map_sigma = random.uniform(0, 0.2);
  batch.options.depth_sigma = random.uniform(0.01, 0.1);
  if (random.chance(0.5)) batch.options.min_depth = random.uniform(0, 5);
  const double broken = random.chance(0.5) ? 0.1 : 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = random.uniform(0.5, 50);
    Eigen::Vector3d p(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z);
    if (random.chance(broken)) p.z() = -z;
    p = R.transpose() * (p - t);
    if (random.chance(broken)) p(random.integer(0, 2)) = broken_value(random);
    if (random.chance(broken)) p *= 1e300;  // what float32 cannot hold
    batch.points.push_back(p);
    batch.sigmas.push_back(random.chance(broken) ? broken_value(random) : random.uniform(0.5, 4));
    batch.has_depth_cue.push_back(static_cast<unsigned char>(random.integer(0, 2)));
    batch.usable.push_back(random.chance(broken) ? 0 : static_cast<unsigned char>(random.integer(1, 255)));
    const Eigen::Matrix3d a = random_block(random, 3).leftCols<3>();
    batch.map_covariances.emplace_back(0.01 * gram(a.transpose()));
    if (random.chance(broken)) batch.map_covariances.back() *= random.chance(0.5) ? nan : -1e6;  // not definite
  }
  if (random.chance(0.2))
    std::fill(batch.has_depth_cue.begin(), batch.has_depth_cue.end(), static_cast<unsigned char>(0));
  batch.matches.size = n;
  batch.matches.points = n == 0 ? nullptr : batch.points[0].data();
  if (random.chance(0.5)) batch.matches.sigmas = batch.sigmas.data();
  if (random.chance(0.5)) batch.matches.has_depth_cue = batch.has_depth_cue.data();
  if (random.chance(0.5)) batch.matches.usable = batch.usable.data();
  if (random.chance(0.5) && n > 0) batch.matches.map_covariances = batch.map_covariances[0].data();
  return batch;
}

ExpectedBlock expected_block(const PinholeBatch& batch, std::size_t i) {
  ExpectedBlock expected;
  const Matches& matches = batch.matches;
  if (matches.usable != nullptr && matches.usable[i] == 0) {
    expected.reason = &BlockReport::unusable;
    return expected;
  }
  const double sigma = matches.sigmas == nullptr ? 1 : matches.sigmas[i];
  const bool has_depth_cue =
      batch.options.depth_cue != DepthCue::none && (matches.has_depth_cue == nullptr || matches.has_depth_cue[i] != 0);
  const Given match{in_camera(batch, i), sigma, has_depth_cue};
  const Point& p = match.p;
  if (p.z <= 0) expected.reason = &BlockReport::behind_camera;
  if (p.z > 0 && p.z < batch.options.min_depth) expected.reason = &BlockReport::too_near;
  if (expected.reason != nullptr || !is_positive(p.z) || !std::isfinite(p.x) || !std::isfinite(p.y)) return expected;
  if (!is_positive(sigma) || !has_block(batch, i, match, expected)) return expected;
  expected.rows = has_depth_cue || batch.options.weighting == Weighting::map_bias_world ? 3 : 2;
  return expected;
}

}  // namespace maxlogdet::test
