// SPDX-License-Identifier: MIT
#include "tests/bench/horn_alignment.hpp"
#include "tests/bench/random_similarity.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

// Points to align: in space, on a plane, close to a line, with and without noise, or mirrored.
struct PointSets {
  std::string kind;
  Matrix3Xd from;
  Matrix3Xd to;
};

PointSets random_points(Random& random) {
  struct Kind {
    const char* name;
    Vector3d extent;
    double noise;
    bool mirrored;
  };
  static const Kind kinds[] = {
      {"exact", {3, 2, 1}, 0, false},      {"noisy", {3, 2, 1}, 0.3, false},
      {"planar", {3, 2, 0}, 0, false},     {"noisy plane", {3, 2, 0}, 0.1, false},
      {"thin", {3, 0.02, 0.01}, 0, false}, {"noisy thin", {3, 0.1, 0.1}, 0.01, false},
      {"mirrored", {3, 2, 1}, 0.1, true},  {"tiny", {3e-6, 2e-6, 1e-6}, 0, false},
  };
  const Kind& kind = kinds[random.integer(0, 7)];
  PointSets sets;
  sets.kind = kind.name;
  const sim::Similarity moved = random_similarity(random);
  const int n = random.integer(kind.mirrored ? 20 : 3, 60);
  sets.from.resize(3, n);
  sets.to.resize(3, n);
  const Eigen::Quaterniond turn = random_rotation(random);
  const Vector3d centre = kind.extent[0] * random_vector(random);
  for (int i = 0; i < n; ++i) {
    const Vector3d point = kind.extent.cwiseProduct(random_vector(random));
    const Vector3d seen = kind.mirrored ? Vector3d(point[0], point[1], -point[2]) : point;
    sets.from.col(i) = turn * point + centre;
    sets.to.col(i) = turn * seen + centre + random_vector(random, kind.noise);
  }
  // Three points on a line by chance would leave the rotation undetermined.
  sets.from.col(1) += turn * Vector3d(kind.extent[0], 0, 0);
  sets.to.col(1) += turn * Vector3d(kind.extent[0], 0, 0);
  sets.from.col(2) += turn * Vector3d(0, kind.extent[1], 0);
  sets.to.col(2) += turn * Vector3d(0, kind.extent[1], 0);
  sets.to = transformed(moved, sets.to);
  return sets;
}

void expect_rotation(const Eigen::Matrix3d& R) {
  EXPECT_TRUE(R.isUnitary(1e-13)) << R;
  EXPECT_GT(R.determinant(), 0) << R;
}

TEST(TrajectoryAlignment, is_that_of_horn) {
  TracedRandom random;
  for (std::size_t trial = trials(1000); trial > 0; --trial) {
    const PointSets sets = random_points(random);
    SCOPED_TRACE(sets.kind);
    const HornAlignment expected = horn(sets.from, sets.to);
    const double tolerance = 1e-12 / expected.separation;  // what rounding of the 4 x 4 matrix does to its eigenvector
    const sim::Similarity sim3 = sim::align_sim3(sets.from, sets.to);
    const sim::Similarity rigid = sim::align_rigid(sets.from, sets.to);
    expect_rotation(sim3.R);
    EXPECT_TRUE(sim3.R.isApprox(expected.similarity.R, tolerance)) << sim3.R << "\n\n" << expected.similarity.R;
    EXPECT_TRUE(rigid.R.isApprox(expected.similarity.R, tolerance));
    EXPECT_NEAR(sim3.scale, expected.similarity.scale, 1e-11 * sim3.scale);
    EXPECT_NEAR((sim3.t - expected.similarity.t).norm(), 0, tolerance * (1 + sim3.t.norm()));
    EXPECT_EQ(rigid.scale, 1);
    const Vector3d mean = sets.from.rowwise().mean();
    EXPECT_TRUE((rigid.R * mean + rigid.t).isApprox(sets.to.rowwise().mean(), 1e-12));
  }
}

TEST(TrajectoryAlignment, keeps_scale_and_rotation_where_points_coincide) {
  TracedRandom random;
  Matrix3Xd spread(3, 10);
  for (auto point : spread.colwise()) point = random_vector(random);
  const Vector3d place = random_vector(random, 100);
  const Matrix3Xd origin = Matrix3Xd::Zero(3, 10);
  Matrix3Xd together = place.replicate(1, 10);
  together(0, 3) = std::nextafter(together(0, 3), 1e9);
  const Matrix3Xd sets[] = {spread, origin, together};
  for (const Matrix3Xd& from : sets) {
    for (const Matrix3Xd& to : sets) {
      if (&from == &to && &from == &sets[0]) continue;
      for (const auto& align : {sim::align_sim3, sim::align_rigid}) {
        const sim::Similarity found = align(from, to);
        EXPECT_EQ(found.scale, 1);
        EXPECT_TRUE(found.R.isIdentity(0));
        EXPECT_NEAR((found.t - (to.rowwise().mean() - from.rowwise().mean())).norm(), 0, 1e-12);
      }
    }
  }
}

TEST(TrajectoryAlignment, of_points_on_a_line_brings_the_lines_together) {
  TracedRandom random;
  for (std::size_t trial = trials(300); trial > 0; --trial) {
    const int n = random.integer(3, 20);
    const Vector3d a = random_vector(random, 5);
    const Vector3d b = random_vector(random, 5);
    const Vector3d along_a = random.chance(0.3) ? Vector3d(Vector3d::UnitX()) : random_vector(random).normalized();
    const Vector3d along_b = random.chance(0.3) ? Vector3d(-along_a) : random_vector(random).normalized();
    Matrix3Xd from(3, n);
    Matrix3Xd to(3, n);
    for (int i = 0; i < n; ++i) {
      from.col(i) = a + (i + random.uniform(0, 0.5)) * along_a;
      to.col(i) = b + 2 * (from.col(i) - a).norm() * along_b;
    }
    const sim::Similarity found = sim::align_sim3(from, to);
    expect_rotation(found.R);
    EXPECT_NEAR(found.scale, 2, 1e-12);
    EXPECT_NEAR((found.R * along_a - along_b).norm(), 0, 1e-12);
    EXPECT_NEAR(squares(found, from, to), 0, 1e-20);
    expect_rotation(sim::align_rigid(from, to).R);
  }
}

TEST(TrajectoryAlignment, of_what_has_nothing_in_common_is_a_similarity) {
  // Sums of products are exactly 0 in all directions: the best scale is 0, and every rotation is equal.
  Matrix3Xd from(3, 4);
  from << 1, -1, 1, -1, 0, 0, 0, 0, 0, 0, 0, 0;
  Matrix3Xd to(3, 4);
  to << 1, 1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0;
  const sim::Similarity found = sim::align_sim3(from, to);
  expect_rotation(found.R);
  EXPECT_EQ(found.scale, 0);
  EXPECT_TRUE(found.t.isZero(0));
}

TEST(TrajectoryAlignment, rejects_what_does_not_correspond) {
  const Matrix3Xd three = Matrix3Xd::Random(3, 3);
  const Matrix3Xd two = three.leftCols(2);
  Matrix3Xd not_finite = three;
  not_finite(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(sim::align_sim3(three, three));
  EXPECT_THROW(sim::align_sim3(three, two), std::invalid_argument);
  EXPECT_THROW(sim::align_rigid(two, two), std::invalid_argument);
  EXPECT_THROW(sim::align_sim3(Matrix3Xd(3, 0), Matrix3Xd(3, 0)), std::invalid_argument);
  EXPECT_THROW(sim::align_sim3(not_finite, three), std::invalid_argument);
  EXPECT_THROW(sim::align_rigid(three, not_finite), std::invalid_argument);
}

}  // namespace
}  // namespace maxlogdet::test
