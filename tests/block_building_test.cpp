// SPDX-License-Identifier: MIT
// append_blocks on every instruction set, against the same equations put down match by match with Eigen: all weightings
// and third measurements, all lengths of the last pack, broken matches anywhere. That the equations are right is what
// jacobian_test.cpp shows.
#include "sim/forced_isa.hpp"
#include "tests/linear_algebra.hpp"
#include "tests/support.hpp"

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
  const double broken = random.chance(0.5) ? 0.1 : 0;  // half of the batches hold whole packs of good matches
  for (std::size_t i = 0; i < n; ++i) {
    const double z = random.uniform(0.5, 50);
    Eigen::Vector3d p(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z);
    if (random.chance(broken)) p.z() = -z;
    p = R.transpose() * (p - t);
    if (random.chance(broken)) p(random.integer(0, 2)) = broken_value(random);
    // What float32 cannot hold; with a covariance, only that the matrix is ill-conditioned would be compared.
    if (random.chance(broken) && weighting != Weighting::measurement_and_map) p *= 1e300;
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

Eigen::Matrix3d cross_product_matrix(const Eigen::Vector3d& p) {
  Eigen::Matrix3d m;
  m << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0;
  return m;
}

struct Expected {
  Block block = Block(0, 6);  // no rows: invalid
  bool is_behind = false;
  bool is_singular = false;
};

Expected expected_block(const Batch& batch, std::size_t i) {
  Expected expected;
  const Matches& matches = batch.matches;
  if (matches.usable != nullptr && matches.usable[i] == 0) return expected;
  const Eigen::Matrix3d R = batch.T_cw.leftCols<3>();
  const Eigen::Vector3d p = R * batch.points[i] + batch.T_cw.col(3);
  const double sigma = matches.sigmas == nullptr ? 1 : matches.sigmas[i];
  const double weight = matches.weights == nullptr ? 1 : matches.weights[i];
  expected.is_behind = p.z() <= 0;
  if (!(p.z() > 0) || !p.allFinite() || !(sigma > 0) || !std::isfinite(sigma) || !(weight >= 0)) return expected;

  const bool has_third =
      batch.options.third != ThirdMeasurement::none && (matches.has_third == nullptr || matches.has_third[i] != 0);
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  Block point_jacobian(3, 6);
  point_jacobian << identity, -cross_product_matrix(p);
  Block h;
  if (batch.options.weighting == Weighting::map_bias) {
    const Eigen::Matrix3d projection = identity - p * Eigen::RowVector3d::UnitZ() / p.z();
    h = has_third ? point_jacobian : Block((projection * point_jacobian).topRows(2));
  } else if (batch.options.weighting == Weighting::map_bias_world) {
    const Eigen::RowVector3d axis = R.col(2);
    expected.is_singular = !has_third && std::abs(axis * p) < 1e-6 * p.norm();
    if (expected.is_singular) return expected;
    const Eigen::Matrix3d projection = identity - p * axis / (axis * p);
    h = product(product(R.transpose(), has_third ? identity : projection), point_jacobian);
  } else {
    const PinholeCamera& camera = batch.camera;
    const bool is_depth = batch.options.third == ThirdMeasurement::depth;
    const int rows = has_third ? 3 : 2;
    Eigen::Matrix3d j;
    j.row(0) << camera.fx / p.z(), 0, -camera.fx * (p.x() / p.z()) / p.z();
    j.row(1) << 0, camera.fy / p.z(), -camera.fy * (p.y() / p.z()) / p.z();
    j.row(2) << j(0, 0), 0, j(0, 2) + camera.bf / p.z() / p.z();
    if (is_depth) j.row(2) << 0, 0, 1;
    Eigen::Vector3d sigmas(sigma, sigma, is_depth ? batch.options.depth_sigma : sigma);
    Eigen::MatrixXd covariance = Eigen::MatrixXd(sigmas.head(rows).cwiseAbs2().asDiagonal());
    if (batch.options.weighting == Weighting::measurement_and_map) {
      const Eigen::MatrixXd h_p = (j * R).topRows(rows);
      const Eigen::Matrix3d map_covariance = matches.map_covariances != nullptr
                                                 ? Eigen::Matrix3d(batch.map_covariances[i])
                                                 : identity * batch.options.map_sigma * batch.options.map_sigma;
      covariance += product(product(h_p, map_covariance), h_p.transpose());
    }
    const Eigen::MatrixXd factor = cholesky(covariance);
    if (!(factor.diagonal().array() > 0).all()) return expected;
    h = solve_lower(factor, product(j, point_jacobian).topRows(rows));
  }
  h *= std::sqrt(weight);
  if (h.cast<float>().allFinite()) expected.block = h;
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
    for (int column = 0; column < 6; ++column) append(blocks.plane(row, column), blocks.size() * sizeof(float));
  }
  append(blocks.column_max(), 6 * sizeof(double));
  return bytes;
}

void expect_built(const BlockStore& before, const Batch& batch, const BlockReport& report, const BlockStore& blocks) {
  const std::size_t first = before.size();
  const std::size_t n = batch.matches.size;
  ASSERT_EQ(blocks.size(), first + n);
  int rows = before.rows();
  std::size_t invalid = 0;
  std::size_t behind = 0;
  std::size_t singular = 0;
  double column_max[6] = {};
  for (std::size_t i = 0; i < n; ++i) {
    SCOPED_TRACE("match " + std::to_string(i));
    const Expected expected = expected_block(batch, i);
    const auto height = static_cast<int>(expected.block.rows());
    rows = std::max(rows, height);
    behind += expected.is_behind ? 1 : 0;
    singular += expected.is_singular ? 1 : 0;
    invalid += height == 0 ? 1 : 0;
    EXPECT_EQ(blocks.is_valid(first + i), height > 0);
    const Block stored = stored_block(blocks, first + i);
    ASSERT_GE(stored.rows(), height);
    EXPECT_TRUE((stored.bottomRows(stored.rows() - height).array() == 0).all());
    if (height == 0) continue;
    EXPECT_LE((stored.topRows(height) - expected.block).cwiseAbs().maxCoeff(),
              1e-6 * expected.block.cwiseAbs().maxCoeff());
  }
  for (std::size_t i = 0; i < first; ++i) {
    SCOPED_TRACE("stored before, " + std::to_string(i));
    const Block stored = stored_block(blocks, i);
    EXPECT_EQ(stored.topRows(before.rows()), stored_block(before, i));
    EXPECT_TRUE((stored.bottomRows(stored.rows() - before.rows()).array() == 0).all());
    EXPECT_EQ(blocks.is_valid(i), before.is_valid(i));
  }
  for (std::size_t i = 0; i < first + n; ++i) {
    const Block stored = stored_block(blocks, i);
    for (int row = 0; row < stored.rows(); ++row) {
      for (int column = 0; column < 6; ++column) {
        column_max[column] = std::max(column_max[column], std::abs(stored(row, column)));
      }
    }
  }
  EXPECT_EQ(blocks.rows(), rows);
  EXPECT_EQ(blocks.invalid_count(), before.invalid_count() + invalid);
  for (int column = 0; column < 6; ++column) EXPECT_EQ(blocks.column_max()[column], column_max[column]);
  EXPECT_EQ(report.status, singular > 0 ? BlockStatus::singular_rays : BlockStatus::ok);
  EXPECT_EQ(report.appended, n);
  EXPECT_EQ(report.invalid, invalid);
  EXPECT_EQ(report.behind_camera, behind);
  EXPECT_EQ(report.singular_rays, singular);
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
