// SPDX-License-Identifier: MIT
// append_blocks on every instruction set, against the same operations put down match by match in plain float64: the
// same bits, for all weightings and third measurements, all lengths of the last pack, broken matches anywhere. That the
// equations are right is what jacobian_test.cpp shows.
#include "tests/support/forced_isa.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <limits>

namespace maxlogdet::test {
namespace {

using sim::ForcedIsa;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

using Pose = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Batch {
  PinholeCamera camera;
  Pose T_cw;
  BlockOptions options;
  std::vector<Eigen::Vector3d> points;
  std::vector<double> sigmas;
  std::vector<double> weights;
  std::vector<unsigned char> has_third;
  std::vector<unsigned char> usable;
  std::vector<Matrix3> map_covariances;
  Matches matches;  // which of the optional arrays are given
};

double broken_value(Random& random) {
  const double values[] = {nan, infinity, -infinity, -1, -0.0};
  return values[random.integer(0, 4)];
}

Batch random_batch(Random& random, std::size_t n, Weighting weighting, ThirdMeasurement third) {
  Batch batch;
  batch.camera = {random.uniform(300, 800), random.uniform(300, 800), 320, 240, random.uniform(20, 400)};
  const Eigen::Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  const Eigen::Matrix3d R = Eigen::AngleAxisd(random.uniform(-3, 3), axis.normalized()).toRotationMatrix();
  const Eigen::Vector3d t(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
  batch.T_cw << R, t;
  batch.options.weighting = weighting;
  batch.options.third = third;
  batch.options.map_sigma = random.uniform(0, 0.2);
  batch.options.depth_sigma = random.uniform(0.01, 0.1);
  if (random.chance(0.5)) batch.options.min_depth = random.uniform(0, 5);
  const double broken = random.chance(0.5) ? 0.1 : 0;  // half of the batches hold whole packs of good matches
  for (std::size_t i = 0; i < n; ++i) {
    const double z = random.uniform(0.5, 50);
    Eigen::Vector3d p(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z);
    if (random.chance(broken)) p.z() = -z;
    p = R.transpose() * (p - t);
    if (random.chance(broken)) p(random.integer(0, 2)) = broken_value(random);
    if (random.chance(broken)) p *= 1e300;  // what float32 cannot hold
    batch.points.push_back(p);
    batch.sigmas.push_back(random.chance(broken) ? broken_value(random) : random.uniform(0.5, 4));
    batch.weights.push_back(random.chance(broken) ? broken_value(random) : random.uniform(0, 2));
    batch.has_third.push_back(static_cast<unsigned char>(random.integer(0, 2)));
    batch.usable.push_back(random.chance(broken) ? 0 : static_cast<unsigned char>(random.integer(1, 255)));
    const Eigen::Matrix3d a = random_block(random, 3).leftCols<3>();
    batch.map_covariances.emplace_back(0.01 * gram(a.transpose()));
    if (random.chance(broken)) batch.map_covariances.back() *= random.chance(0.5) ? nan : -1e6;  // not definite
  }
  if (random.chance(0.2)) std::fill(batch.has_third.begin(), batch.has_third.end(), static_cast<unsigned char>(0));
  batch.matches.size = n;
  batch.matches.points = n == 0 ? nullptr : batch.points[0].data();
  if (random.chance(0.5)) batch.matches.sigmas = batch.sigmas.data();
  if (random.chance(0.5)) batch.matches.weights = batch.weights.data();
  if (random.chance(0.5)) batch.matches.has_third = batch.has_third.data();
  if (random.chance(0.5)) batch.matches.usable = batch.usable.data();
  if (random.chance(0.5) && n > 0) batch.matches.map_covariances = batch.map_covariances[0].data();
  return batch;
}

// What append_blocks computes of a match, one operation after the other, each rounded to float64.

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

// One match, with what holds where an array is not given.
struct Given {
  Point p;  // in the camera frame
  double sigma;
  bool has_third;
};

Point in_camera(const Batch& batch, std::size_t i) {
  const Eigen::Vector3d& p = batch.points[i];
  const auto coordinate = [&](int row) {
    return batch.T_cw(row, 0) * p.x() + batch.T_cw(row, 1) * p.y() + batch.T_cw(row, 2) * p.z() + batch.T_cw(row, 3);
  };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

// What is known along the ray, of (dX - x dZ, dY - y dZ, dZ), as rows of (dX, dY, dZ).
void from_ray(double x, double y, Triangle& a) {
  a.a02 = a.a02 - a.a00 * x - a.a01 * y;
  a.a12 = a.a12 - a.a11 * y;
}

Triangle map_bias_triangle(const Given& match) {
  const auto& [p, sigma, has_third] = match;
  Triangle a;
  a.a00 = a.a11 = 1;
  a.a02 = has_third ? 0 : -(p.x / p.z);
  a.a12 = has_third ? 0 : -(p.y / p.z);
  a.a22 = has_third ? 1 : 0;
  return a;
}

// False where a variance is zero.
bool measurement_triangle(const Batch& batch, const Given& match, Triangle& a) {
  const double root_half = std::sqrt(0.5);
  const double inverse_z = 1 / match.p.z;
  const double weight = batch.matches.sigmas == nullptr ? inverse_z : inverse_z / match.sigma;
  bool is_definite = match.sigma * match.sigma > 0;
  a.a00 = batch.camera.fx * weight;
  a.a11 = batch.camera.fy * weight;
  if (match.has_third && batch.options.third == ThirdMeasurement::stereo) {
    a.a00 = a.a00 * (2 * root_half);
    a.a02 = a.a22 = batch.camera.bf * root_half * (inverse_z * weight);
  } else if (match.has_third) {
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

// Of the point as measured, along the ray.
Symmetric measured_along_ray(const Batch& batch, const Given& match) {
  const double variance = match.sigma * match.sigma;
  const double a = match.p.z * (1 / batch.camera.fx);
  const double b = match.p.z * (1 / batch.camera.fy);
  Symmetric s{a * a * variance, 0, 0, b * b * variance, 0, 0};
  if (batch.options.third == ThirdMeasurement::stereo) {
    const double per_pixel = match.p.z * match.p.z * (1 / batch.camera.bf);
    s.xz = -(a * per_pixel * variance);
    s.zz = per_pixel * per_pixel * (variance + variance);
  } else if (batch.options.third == ThirdMeasurement::depth) {
    s.zz = batch.options.depth_sigma * batch.options.depth_sigma;
  }
  return s;
}

// A with A^T A = S^-1, of the first two coordinates alone without a third measurement; false where S is not positive
// definite.
bool whiten(const Symmetric& s, bool has_third, Triangle& a) {
  const double inverse_zz = has_third ? 1 / std::sqrt(s.zz) : 0;
  const double xz = has_third ? s.xz * inverse_zz : 0;
  const double yz = has_third ? s.yz * inverse_zz : 0;
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
  return (!has_third || is_positive(s.zz)) && is_positive(yy) && is_positive(xx);
}

// Whether rounding has left digits (docs/numerics.md): A along the ray, x and y its direction.
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

bool whitened_triangle(const Batch& batch, std::size_t i, const Given& match, Triangle& a) {
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
  const bool is_definite = whiten(s, match.has_third, a);
  const bool has_covariance = batch.matches.map_covariances != nullptr;
  const bool is_sound =
      keeps_digits(a, x, y, batch.options, has_covariance ? batch.map_covariances[i].data() : nullptr);
  from_ray(x, y, a);
  const bool has_depth = match.has_third && batch.options.third == ThirdMeasurement::depth;
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

// False where the ray is orthogonal to the world's z axis.
bool map_bias_world_rows(const Pose& T_cw, const Given& match, Rows& h) {
  const Point& p = match.p;
  const double share = T_cw(0, 2) * p.x + T_cw(1, 2) * p.y + T_cw(2, 2) * p.z;
  const double norm = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  for (int i = 0; i < 3; ++i) {
    const double projected = T_cw(0, i) * p.x + T_cw(1, i) * p.y + T_cw(2, i) * p.z;
    double b[3];
    for (int j = 0; j < 3; ++j) b[j] = T_cw(j, i) - projected * (match.has_third ? 0 : T_cw(j, 2) / share);
    const double row[6] = {b[0], b[1], b[2], b[2] * p.y - b[1] * p.z, b[0] * p.z - b[2] * p.x, b[1] * p.x - b[0] * p.y};
    std::copy_n(row, 6, h[i]);
  }
  return match.has_third || !(std::abs(share) < 1e-6 * norm);
}

struct Expected {
  int rows = 0;              // 0: invalid
  float entries[3][6] = {};  // as stored; a third row that is not there is one of zeros, of either sign
  bool is_behind = false;
  bool is_near = false;
  bool is_singular = false;
  bool is_unsound = false;
};

// The block itself; false if there is none, or not one that float32 holds.
bool has_block(const Batch& batch, std::size_t i, const Given& match, double weight, Expected& expected) {
  Rows h = {};
  Triangle a;
  bool is_definite = true;
  switch (batch.options.weighting) {
    case Weighting::map_bias: a = map_bias_triangle(match); break;
    case Weighting::measurement: is_definite = measurement_triangle(batch, match, a); break;
    case Weighting::measurement_and_map: is_definite = whitened_triangle(batch, i, match, a); break;
    case Weighting::map_bias_world: expected.is_singular = !map_bias_world_rows(batch.T_cw, match, h);
  }
  if (batch.options.weighting != Weighting::map_bias_world) multiply_by_point_jacobian(a, match.p, h);
  bool is_held = true;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 6; ++column) {
      if (batch.matches.weights != nullptr) h[row][column] *= std::sqrt(weight);
      expected.entries[row][column] = static_cast<float>(h[row][column]);
      is_held = is_held && std::isfinite(expected.entries[row][column]);
    }
  }
  expected.is_unsound = !is_definite;
  return is_definite && is_held && !expected.is_singular;
}

Expected expected_block(const Batch& batch, std::size_t i) {
  Expected expected;
  const Matches& matches = batch.matches;
  if (matches.usable != nullptr && matches.usable[i] == 0) return expected;
  const double sigma = matches.sigmas == nullptr ? 1 : matches.sigmas[i];
  const double weight = matches.weights == nullptr ? 1 : matches.weights[i];
  const bool has_third =
      batch.options.third != ThirdMeasurement::none && (matches.has_third == nullptr || matches.has_third[i] != 0);
  const Given match{in_camera(batch, i), sigma, has_third};
  const Point& p = match.p;
  expected.is_behind = p.z <= 0;
  expected.is_near = p.z > 0 && p.z < batch.options.min_depth;
  if (!is_positive(p.z) || expected.is_near || !std::isfinite(p.x) || !std::isfinite(p.y)) return expected;
  if (!is_positive(sigma) || !(weight >= 0) || !has_block(batch, i, match, weight, expected)) return expected;
  expected.rows = has_third || batch.options.weighting == Weighting::map_bias_world ? 3 : 2;
  return expected;
}

// All that a store says of its candidates, byte by byte.
std::vector<unsigned char> bytes_of(const BlockStore& blocks) {
  std::vector<unsigned char> bytes(blocks.validity(), blocks.validity() + blocks.size());
  const auto append = [&](const void* data, std::size_t size) {
    const std::size_t end = bytes.size();
    bytes.resize(end + size);
    if (size > 0) std::memcpy(bytes.data() + end, data, size);
  };
  for (int row = 0; row < blocks.rows(); ++row) {
    for (int column = 0; column < 6; ++column) append(blocks.plane(row, column), blocks.stored() * sizeof(float));
  }
  append(blocks.indices(), blocks.stored() * sizeof(std::uint32_t));
  append(blocks.column_max(), 6 * sizeof(double));
  return bytes;
}

// Bit for bit, but for the sign of the zeros in a row that is not there.
void expect_entries(const BlockStore& blocks, std::size_t candidate, const Expected& expected) {
  const std::size_t place = blocks.place(candidate);
  for (int row = 0; row < blocks.rows(); ++row) {
    for (int column = 0; column < 6; ++column) {
      const float stored = blocks.plane(row, column)[place];
      const float wanted = expected.entries[row][column];
      EXPECT_EQ(stored, wanted) << "entry " << row << ", " << column;
      if (row >= expected.rows) continue;
      EXPECT_EQ(std::memcmp(&stored, &wanted, sizeof stored), 0) << "sign of entry " << row << ", " << column;
    }
  }
}

void expect_kept(const BlockStore& before, const BlockStore& blocks) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    SCOPED_TRACE("stored before, " + std::to_string(i));
    const Block stored = stored_block(blocks, i);
    EXPECT_EQ(stored.topRows(before.rows()), stored_block(before, i));
    EXPECT_TRUE((stored.bottomRows(stored.rows() - before.rows()).array() == 0).all());
    EXPECT_EQ(blocks.is_valid(i), before.is_valid(i));
  }
}

void expect_column_max(const BlockStore& blocks) {
  Eigen::Matrix<double, 1, 6> largest = Eigen::Matrix<double, 1, 6>::Zero();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block stored = stored_block(blocks, i);
    for (int row = 0; row < stored.rows(); ++row) largest = largest.cwiseMax(stored.row(row).cwiseAbs());
  }
  for (int column = 0; column < 6; ++column) EXPECT_EQ(blocks.column_max()[column], largest(column));
}

void expect_built(const BlockStore& before, const Batch& batch, const BlockReport& report, const BlockStore& blocks) {
  const std::size_t first = before.size();
  const std::size_t n = batch.matches.size;
  ASSERT_EQ(blocks.size(), first + n);
  int rows = before.rows();
  std::size_t invalid = 0;
  std::size_t behind = 0;
  std::size_t near = 0;
  std::size_t singular = 0;
  std::size_t unsound = 0;
  for (std::size_t i = 0; i < n; ++i) {
    SCOPED_TRACE("match " + std::to_string(i));
    const Expected expected = expected_block(batch, i);
    rows = std::max(rows, expected.rows);
    behind += expected.is_behind ? 1 : 0;
    near += expected.is_near ? 1 : 0;
    singular += expected.is_singular ? 1 : 0;
    unsound += expected.is_unsound ? 1 : 0;
    invalid += expected.rows == 0 ? 1 : 0;
    ASSERT_EQ(blocks.is_valid(first + i), expected.rows > 0);
    ASSERT_GE(blocks.rows(), expected.rows);
    if (expected.rows > 0) expect_entries(blocks, first + i, expected);
  }
  expect_kept(before, blocks);
  expect_column_max(blocks);
  EXPECT_EQ(blocks.rows(), rows);
  EXPECT_EQ(blocks.invalid_count(), before.invalid_count() + invalid);
  EXPECT_EQ(report.status, singular > 0 ? BlockStatus::singular_rays : BlockStatus::ok);
  EXPECT_EQ(report.appended, n);
  EXPECT_EQ(report.invalid, invalid);
  EXPECT_EQ(report.behind_camera, behind);
  EXPECT_EQ(report.too_near, near);
  EXPECT_EQ(report.singular_rays, singular);
  EXPECT_EQ(report.unsound_covariances, unsound);
  EXPECT_EQ(report.invalid_jacobians, 0U);
}

TEST(BlockBuilding, is_the_obvious_computation_and_the_same_bits_on_every_instruction_set) {
  for (const Weighting weighting : weightings) {
    for (const ThirdMeasurement third : {ThirdMeasurement::none, ThirdMeasurement::stereo, ThirdMeasurement::depth}) {
      for (std::size_t n = 0; n <= 70; ++n) {
        Random random(n);
        SCOPED_TRACE(std::to_string(n) + " matches, " + to_string(weighting) + ", third " +
                     std::to_string(static_cast<int>(third)));
        const Batch batch = random_batch(random, n, weighting, third);
        std::vector<Block> stored_before;
        for (int i = random.integer(0, 5); i > 0; --i)
          stored_before.push_back(random_block(random, random.integer(0, 3)));
        std::vector<unsigned char> expected;
        for (const std::string& isa : sim::supported_isas()) {
          SCOPED_TRACE(isa);
          const ForcedIsa forced(isa.c_str());
          BlockStore blocks(stored_before.size() + n);  // a plane may end with the last match
          for (const Block& block : stored_before) push_back(blocks, block);
          const BlockStore before = blocks;
          const BlockReport report =
              append_blocks(batch.camera, batch.T_cw.data(), batch.matches, batch.options, blocks);
          expect_built(before, batch, report, blocks);
          if (expected.empty()) expected = bytes_of(blocks);
          EXPECT_EQ(bytes_of(blocks), expected) << "not the bits of " << sim::supported_isas().front();
          if (::testing::Test::HasFailure()) return;  // one is enough to look at
        }
      }
    }
  }
}

TEST(BlockBuilding, stays_at_two_rows_where_no_valid_match_has_a_third) {
  const double points[9] = {0.1, 0.2, 3, 0.3, -0.1, -4, 0.2, 0.1, 5};
  const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const unsigned char has_third[3] = {0, 1, 0};  // the one that has is behind the camera
  Matches matches;
  matches.size = 3;
  matches.points = points;
  matches.has_third = has_third;
  BlockOptions options;
  options.third = ThirdMeasurement::stereo;
  BlockStore blocks;
  append_blocks({400, 400, 320, 240, 40}, identity, matches, options, blocks);
  EXPECT_EQ(blocks.rows(), 2);
  EXPECT_EQ(blocks.invalid_count(), 1U);
}

TEST(BlockBuilding, a_variance_of_zero_is_not_positive_definite) {
  const double points[6] = {0.1, 0.2, 3, 0.1, 0.2, 3};
  const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const double sigmas[2] = {1e-200, 1};  // positive, but its square is not
  Matches matches;
  matches.size = 2;
  matches.points = points;
  matches.sigmas = sigmas;
  BlockOptions options;
  options.weighting = Weighting::measurement;
  BlockStore blocks;
  const BlockReport report = append_blocks({400, 400, 320, 240, 40}, identity, matches, options, blocks);
  EXPECT_EQ(report.invalid, 1U);
  EXPECT_FALSE(blocks.is_valid(0));
  EXPECT_TRUE(blocks.is_valid(1));
}

// A is upper triangular and [I | -[p]x] has a diagonal of zeros in its right half, so of a block in the camera frame
// entry (1, 0) is zero, and of its third row (2, 0), (2, 1) and (2, 5).
TEST(BlockBuilding, rows_are_zero_below_the_diagonal) {
  for (const Weighting weighting : {Weighting::map_bias, Weighting::measurement, Weighting::measurement_and_map}) {
    for (const ThirdMeasurement third : {ThirdMeasurement::none, ThirdMeasurement::stereo, ThirdMeasurement::depth}) {
      Random random(static_cast<std::uint64_t>(third));
      SCOPED_TRACE(random.name() + ", " + to_string(weighting));
      const Batch batch = random_batch(random, 100, weighting, third);
      BlockStore blocks;
      append_blocks(batch.camera, batch.T_cw.data(), batch.matches, batch.options, blocks);
      EXPECT_GT(blocks.stored(), 50U);
      for (const double largest : {blocks.column_max()[0], blocks.column_max()[5]}) EXPECT_GT(largest, 0);
      for (std::size_t i = 0; i < blocks.stored(); ++i) {
        EXPECT_EQ(blocks.plane(1, 0)[i], 0);
        for (const int column : {0, 1, 5}) EXPECT_EQ(blocks.rows() == 3 ? blocks.plane(2, column)[i] : 0, 0);
      }
    }
  }
}

TEST(BlockBuilding, reads_the_upper_triangle_of_a_covariance_alone) {
  for (const ThirdMeasurement third : {ThirdMeasurement::none, ThirdMeasurement::stereo, ThirdMeasurement::depth}) {
    Random random(static_cast<std::uint64_t>(third));
    SCOPED_TRACE(random.name());
    Batch batch = random_batch(random, 100, Weighting::measurement_and_map, third);
    batch.matches.map_covariances = batch.map_covariances[0].data();
    BlockStore whole;
    append_blocks(batch.camera, batch.T_cw.data(), batch.matches, batch.options, whole);
    ASSERT_GT(whole.stored(), 0U);
    for (Matrix3& covariance : batch.map_covariances) covariance(1, 0) = covariance(2, 0) = covariance(2, 1) = nan;
    BlockStore upper;
    append_blocks(batch.camera, batch.T_cw.data(), batch.matches, batch.options, upper);
    EXPECT_EQ(bytes_of(upper), bytes_of(whole));
  }
}

TEST(BlockBuilding, does_not_need_a_valid_instruction_set) {
  const double point[3] = {0.1, 0.2, 3};
  const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  Matches matches;
  matches.size = 1;
  matches.points = point;
  BlockStore expected;
  append_blocks({400, 400, 320, 240, 40}, identity, matches, BlockOptions(), expected);
  const ForcedIsa forced("none of these");
  BlockStore blocks;
  EXPECT_EQ(append_blocks({400, 400, 320, 240, 40}, identity, matches, BlockOptions(), blocks).status, BlockStatus::ok);
  EXPECT_EQ(bytes_of(blocks), bytes_of(expected));
}

}  // namespace
}  // namespace maxlogdet::test
