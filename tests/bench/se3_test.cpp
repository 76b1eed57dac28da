// SPDX-License-Identifier: MIT
#include "bench/world/se3.hpp"
#include "tests/support/random_isometry.hpp"
#include "tests/support/support.hpp"

#include <Eigen/LU>
#include <unsupported/Eigen/MatrixFunctions>

namespace maxlogdet::test {
namespace {

using sim::Pose;
using sim::Vector6;

constexpr double pi = 3.14159265358979323846;
constexpr double angles[] = {0,   1e-12, 1e-8, 1e-5, 1e-3, 0.1,       0.5,       1,
                             2.5, 2.999, 3,    3.01, 3.14, pi - 1e-6, pi - 1e-9, pi - 1e-12};

Vector6 random_xi(Random& random, double angle) {
  Vector6 xi;
  xi << 5 * random_vector(random, 1), angle * random_vector(random, 1).normalized();
  return xi;
}

template <class Body>
void for_every_angle(const Body& body) {
  for (const double angle : angles) {
    Random random(static_cast<std::uint64_t>(1e6 * angle));
    SCOPED_TRACE(random.name() + " angle " + std::to_string(angle));
    for (std::size_t trial = trials(20); trial > 0; --trial) body(random, angle);
  }
}

Eigen::Matrix4d hat(const Vector6& xi) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m.topLeftCorner<3, 3>() = sim::skew(xi.tail<3>());
  m.topRightCorner<3, 1>() = xi.head<3>();
  return m;
}

double largest_difference(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

TEST(Se3, skew_is_the_cross_product) {
  TracedRandom random;
  const Eigen::Vector3d v = random_vector(random, 1);
  const Eigen::Vector3d w = random_vector(random, 1);
  EXPECT_LT((sim::skew(v) * w - v.cross(w)).norm(), 1e-15);
}

TEST(Se3, log_inverts_exp) {
  for_every_angle([](Random& random, double angle) {
    const Vector6 xi = random_xi(random, angle);
    const Vector6 back = sim::log_se3(sim::exp_se3(xi));
    EXPECT_LT((back - xi).head<3>().norm(), 1e-13);
    EXPECT_LE((back - xi).tail<3>().norm(), 1e-14 * angle) << "a small rotation keeps its digits";
  });
}

TEST(Se3, exp_is_the_matrix_exponential) {
  for_every_angle([](Random& random, double angle) {
    const Vector6 xi = random_xi(random, angle), turns = random_xi(random, random.uniform(pi, 30));
    EXPECT_LT((sim::exp_se3(xi).matrix() - Eigen::Matrix4d(hat(xi).exp())).cwiseAbs().maxCoeff(), 2e-13);
    EXPECT_LT((sim::exp_se3(turns).matrix() - Eigen::Matrix4d(hat(turns).exp())).cwiseAbs().maxCoeff(), 1e-11);
    const Eigen::Matrix3d R = sim::exp_se3(xi).linear();
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  });
}

TEST(Se3, adjoint_moves_a_perturbation_to_the_left) {
  for_every_angle([](Random& random, double angle) {
    const Pose T = sim::exp_se3(random_xi(random, random.uniform(0, 3)));
    const Vector6 xi = random_xi(random, angle);
    EXPECT_LT(largest_difference(T * sim::exp_se3(xi) * T.inverse(), sim::exp_se3(sim::adjoint(T) * xi)), 1e-12);
  });
}

// sum_n ad(xi)^n / (n + 1)!, its definition
Matrix6 left_jacobian_by_series(const Vector6& xi) {
  Matrix6 ad = Matrix6::Zero();
  ad.topLeftCorner<3, 3>() = ad.bottomRightCorner<3, 3>() = sim::skew(xi.tail<3>());
  ad.topRightCorner<3, 3>() = sim::skew(xi.head<3>());
  Matrix6 term = Matrix6::Identity();
  Matrix6 sum = term;
  for (int n = 1; n < 60; ++n) sum += term = term * ad / (n + 1.0);
  return sum;
}

TEST(Se3, left_jacobian_is_its_series) {
  for_every_angle([](Random& random, double angle) {
    const Vector6 xi = random_xi(random, angle);
    EXPECT_LT((sim::left_jacobian(xi) - left_jacobian_by_series(xi)).cwiseAbs().maxCoeff(), 2e-13);
  });
}

TEST(Se3, rotation_angle_is_exact) {
  for_every_angle([](Random& random, double angle) {
    const Eigen::Matrix3d R = sim::exp_se3(random_xi(random, angle)).linear();
    EXPECT_NEAR(sim::rotation_angle(R), angle, 1e-14 * angle);
    EXPECT_NEAR(sim::rotation_angle(R.transpose()), angle, 1e-14 * angle);
  });
  const Eigen::Matrix3d R = Eigen::AngleAxisd(4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_NEAR(sim::rotation_angle(R), 2 * pi - 4, 1e-14) << "a turn of more than pi is one of less";
}

TEST(Se3, cameras_are_as_far_apart_as_their_centres_and_turned_by_the_angle_between_them) {
  Pose a = Pose::Identity(), b = Pose::Identity();
  a.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix();
  a.translation() = a.linear() * Eigen::Vector3d(-1, -2, -3);  // at (1, 2, 3)
  b.translation() = Eigen::Vector3d(-1, -2, -7);
  EXPECT_NEAR(sim::camera_distance(a, b), 4, 1e-12);
  EXPECT_NEAR(sim::camera_angle_deg(a, b), 0.3 * 180 / 3.141592653589793, 1e-10);
}

TEST(Se3, the_nearest_pose_projects_onto_rotations) {
  TracedRandom random;
  for (std::size_t i = trials(200); i > 0; --i) {
    const Pose T = sim::exp_se3(random_xi(random, 2));
    Eigen::Matrix<double, 3, 4> rows = T.matrix().topRows<3>();
    for (double& entry : rows.leftCols<3>().reshaped()) entry += random.uniform(-1e-4, 1e-4);
    const auto pose = sim::nearest_pose(rows);
    ASSERT_TRUE(pose.has_value());
    EXPECT_TRUE(pose->linear().isUnitary(1e-14));
    EXPECT_TRUE(pose->isApprox(T, 1e-3));
    EXPECT_EQ(pose->translation(), T.translation());
    const Eigen::Matrix3d stretch = pose->linear().transpose() * rows.leftCols<3>();
    EXPECT_TRUE(stretch.isApprox(stretch.transpose(), 1e-14)) << "the polar decomposition is the nearest";
  }
  Eigen::Matrix<double, 3, 4> rows = Pose::Identity().matrix().topRows<3>();
  EXPECT_FALSE(sim::nearest_pose(1.001 * rows).has_value());
  EXPECT_FALSE(sim::nearest_pose(-rows).has_value()) << "a reflection";
  rows(0, 1) = 1e200;
  EXPECT_FALSE(sim::nearest_pose(rows).has_value());
}

TEST(Se3, rows_hold_a_pose) {
  const std::array<double, 12> rows = {0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6};
  const Pose T = sim::pose_of(rows);
  EXPECT_EQ(T * Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(2, 6, 9));
  EXPECT_EQ(sim::to_rows(T), rows);
}

}  // namespace
}  // namespace maxlogdet::test
