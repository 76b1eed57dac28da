// SPDX-License-Identifier: MIT
// Poses against the matrix exponential, and errors of trajectories against their definition.
#include "bench/does_the_paper_hold/trajectory.hpp"
#include "bench/world/se3.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <Eigen/LU>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace maxlogdet::test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using sim::pi;
using sim::Pose;
using Poses = std::vector<sim::StampedPose>;

Vector6 random_xi(Random& random, double angle) {
  Vector6 xi;
  xi << 5 * random_vector(random, 1), angle * random_vector(random, 1).normalized();
  return xi;
}

Eigen::Matrix4d exponential(const Vector6& xi) {
  Eigen::Matrix4d hat = Eigen::Matrix4d::Zero();
  for (int j = 0; j < 3; ++j) hat.col(j).head<3>() = xi.tail<3>().cross(Vector3d::Unit(j));
  hat.topRightCorner<3, 1>() = xi.head<3>();
  return hat.exp();
}

TEST(Se3, exp_is_the_matrix_exponential_and_log_its_inverse_at_every_angle) {
  TracedRandom random;
  for (const double angle :
       {0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1.0, 2.5, 3.0, 3.14, pi - 1e-6, pi - 1e-9, pi - 1e-12}) {
    SCOPED_TRACE(angle);
    for (std::size_t trial = trials(20); trial > 0; --trial) {
      const Vector6 xi = random_xi(random, angle), turns = random_xi(random, random.uniform(pi, 30));
      const Pose T = sim::exp_se3(xi);
      EXPECT_LT((T.matrix() - exponential(xi)).cwiseAbs().maxCoeff(), 2e-13);
      EXPECT_LT((sim::exp_se3(turns).matrix() - exponential(turns)).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_TRUE(T.linear().isUnitary(1e-14));
      const Vector6 error = sim::log_se3(T) - xi;
      EXPECT_LT(error.head<3>().norm(), 1e-13);
      EXPECT_LE(error.tail<3>().norm(), 1e-14 * angle) << "a small rotation keeps its digits";
      EXPECT_NEAR(sim::rotation_angle(T.linear()), angle, 1e-14 * angle);
      EXPECT_NEAR(sim::rotation_angle(T.linear().transpose()), angle, 1e-14 * angle);
      EXPECT_LT((sim::skew(xi.head<3>()) * xi.tail<3>() - xi.head<3>().cross(xi.tail<3>())).norm(), 1e-14);
    }
  }
}

TEST(Se3, cameras_are_as_far_apart_as_their_centres_and_turned_by_the_angle_between_them) {
  const std::array<double, 12> rows = {0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6};  // at (-5, 4, -6)
  const Pose a = sim::pose_of(rows), b(Eigen::Translation3d(5, -4, 9));
  EXPECT_EQ(a * Vector3d(1, 2, 3), Vector3d(2, 6, 9));
  EXPECT_EQ(sim::to_rows(a), rows);
  EXPECT_NEAR(sim::camera_distance(a, b), 3, 1e-12);
  EXPECT_NEAR(sim::camera_angle_deg(a, b), 90, 1e-10);
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

class TrajectoryReader : public TextFolder {};

TEST_F(TrajectoryReader, reads_a_folder_in_order_and_names_the_line_that_is_wrong) {
  const Lines good = {"# timestamp tx ty tz qx qy qz qw", "1403636580.83856 4.688319 -1.786938 0.783338 0 0 0 1.009",
                      "\t1403636580.88856  4.5\t-1.5 0.75 0 0 0.6 0.8 # a comment\r",
                      "1403636580.93856 -4 1e-3 0 0.5 -0.5 0.5 -0.5"};
  for (const char* const name : {"V2.txt", "V1_01.txt"}) write(name, good);
  write("A.csv", {"not a trajectory"});
  const auto trajectories = sim::read_trajectories(folder_);
  ASSERT_EQ(trajectories.size(), 2U);
  EXPECT_EQ(trajectories[0].name, "V1_01");
  const Poses& poses = trajectories[0].poses;
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(poses[0].time, 1403636580.83856);
  EXPECT_EQ(poses[0].T_wb.translation(), Vector3d(4.688319, -1.786938, 0.783338));
  EXPECT_TRUE(poses[0].T_wb.linear().isIdentity(1e-15));
  const Eigen::AngleAxisd about_z(2 * std::acos(0.8), Vector3d::UnitZ());
  EXPECT_TRUE(poses[1].T_wb.linear().isApprox(about_z.toRotationMatrix(), 1e-15));
  EXPECT_LT((poses[2].T_wb.linear() * Vector3d(1, 2, 3) - Vector3d(3, -1, -2)).norm(), 1e-14);

  std::filesystem::remove(path("V1_01.txt"));
  const std::vector<BrokenLine> broken = {
      {3, "5 0 0 0 0 0 1", "expected 8 fields 'timestamp tx ty tz qx qy qz qw', not 7"},
      {2, "1 0 nan 0 0 0 0 1", "expected a finite number for ty, not 'nan'"},
      {3, "1403636580.83856 0 0 0 0 0 0 1", "expected a timestamp later than that of the pose before"},
      {2, "1 0 0 0 0 0 0 1.011", "expected a quaternion qx qy qz qw of norm 1 within 0.01"},
  };
  expect_every_one_refused("V2.txt", good, broken, [&] { sim::read_trajectories(folder_); });
  write("V2.txt", {good[1], good[2]});
  expect_input_error([&] { sim::read_trajectories(folder_); }, path("V2.txt") + ":2", "expected at least 3 poses");
}

Matrix3Xd positions_of(const Poses& poses) {
  Matrix3Xd positions(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = poses[i].T_wb.translation();
  }
  return positions;
}

struct Similarity {
  double scale;
  Eigen::Matrix3d R;
  Vector3d t;

  Matrix3Xd operator*(const Matrix3Xd& points) const { return (scale * product(R, points)).colwise() + t; }
};

// Horn, Closed-form solution of absolute orientation using unit quaternions, 1987.
Similarity horn(const Matrix3Xd& from, const Matrix3Xd& to) {
  const Vector3d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  const Matrix3Xd p = from.colwise() - from_mean, q = to.colwise() - to_mean;
  const Eigen::Matrix3d M = product(p, q.transpose());
  const Vector3d skewed(M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0));
  Eigen::Matrix4d N;
  N << M.trace(), skewed.transpose(), skewed, M + M.transpose() - M.trace() * Eigen::Matrix3d::Identity();
  const Eigen::Vector4d w = spectrum(N).vectors.col(3);
  const Eigen::Matrix3d R = Eigen::Quaterniond(w[0], w[1], w[2], w[3]).normalized().toRotationMatrix();
  const double scale = q.cwiseProduct(product(R, p)).sum() / p.squaredNorm();
  return {scale, R, to_mean - scale * R * from_mean};
}

// By 4 x 4 matrices, general inverses, every pair of poses, and Horn's alignment.
sim::TrajectoryErrors errors_by_definition(const Poses& estimate, const Poses& truth, double window) {
  const Similarity s = horn(positions_of(estimate), positions_of(truth));
  const Matrix3Xd positions = s * positions_of(estimate);
  const auto aligned = [&](std::size_t i) {
    Eigen::Matrix4d P = Eigen::Matrix4d::Identity();
    P.topLeftCorner<3, 3>() = s.R * estimate[i].T_wb.linear();
    P.topRightCorner<3, 1>() = positions.col(static_cast<Eigen::Index>(i));
    return P;
  };
  sim::TrajectoryErrors errors;
  errors.ate_m = std::sqrt((positions - positions_of(truth)).colwise().squaredNorm().mean());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    std::size_t j = i + 1;
    while (j < truth.size() && truth[j].time - truth[i].time < window - 0.5e-6) ++j;
    if (j == truth.size() || truth[j].time - truth[i].time > window + 0.5) continue;
    const double time = truth[j].time - truth[i].time;
    const Eigen::Matrix4d true_motion = product(inverse(truth[i].T_wb.matrix()), truth[j].T_wb.matrix());
    const Eigen::Matrix4d drift = product(inverse(true_motion), product(inverse(aligned(i)), aligned(j)));
    errors.rpe_m_per_s += drift.topRightCorner<3, 1>().norm() / time;
    errors.roe_deg_per_s += 180 / pi * Eigen::AngleAxisd(Eigen::Matrix3d(drift.topLeftCorner<3, 3>())).angle() / time;
    ++errors.windows;
  }
  errors.rpe_m_per_s /= static_cast<double>(errors.windows);
  errors.roe_deg_per_s /= static_cast<double>(errors.windows);
  return errors;
}

TEST(TrajectoryErrors, are_those_of_the_definition_also_over_missing_poses) {
  TracedRandom random;
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    Poses truth, estimate;
    double time = 1403636580.83856;
    Pose T = random_isometry(random, 5, 1);
    const double noise = random.uniform(0, 0.5), window = random.uniform(0.5, 4);
    const Similarity moved{std::exp(random.uniform(-2, 2)), random_isometry(random, 0, 3).linear(),
                           random_vector(random, 10)};
    for (int i = 0; i < 240; ++i) {
      time += random.chance(0.02) ? random.uniform(0.2, 2) : random.uniform(0.03, 0.07);
      T = T * random_isometry(random, 0.1, 0.1);
      truth.push_back({time, T});
      const Pose off = T * random_isometry(random, noise, noise);
      estimate.push_back({time, Eigen::Translation3d(Vector3d(moved * off.translation())) *
                                    Eigen::Quaterniond(Eigen::Matrix3d(moved.R * off.linear()))});
    }
    const auto errors = sim::trajectory_errors(estimate, truth, window);
    const auto expected = errors_by_definition(estimate, truth, window);
    EXPECT_NEAR(errors.ate_m, expected.ate_m, 1e-10);
    EXPECT_NEAR(errors.rpe_m_per_s, expected.rpe_m_per_s, 1e-10);
    EXPECT_NEAR(errors.roe_deg_per_s, expected.roe_deg_per_s, 1e-8);
    EXPECT_EQ(errors.windows, expected.windows);
    EXPECT_GT(errors.windows, 0U);
  }
}

}  // namespace
}  // namespace maxlogdet::test
