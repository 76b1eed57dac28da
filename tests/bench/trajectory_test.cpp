// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/trajectory_error.hpp"

#include "bench/world/angles.hpp"
#include "tests/bench/flight.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

namespace maxlogdet::test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Poses = std::vector<sim::StampedPose>;

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
  Eigen::Matrix3d turned;  // about z, by twice the angle whose cosine is 0.8
  turned << 0.28, -0.96, 0, 0.96, 0.28, 0, 0, 0, 1;
  EXPECT_TRUE(poses[1].T_wb.linear().isApprox(turned, 1e-15));
  turned << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  EXPECT_TRUE(poses[2].T_wb.linear().isApprox(turned, 1e-15));

  const std::vector<BrokenLine> broken = {
      {3, "5 0 0 0 0 0 1", "expected 8 fields 'timestamp tx ty tz qx qy qz qw', not 7"},
      {2, "1 0 nan 0 0 0 0 1", "expected a finite number for ty, not 'nan'"},
      {3, "1403636580.83856 0 0 0 0 0 0 1", "expected a timestamp later than that of the pose before"},
      {2, "1 0 0 0 0 0 0 1.011", "expected a quaternion qx qy qz qw of norm 1 within 0.01"},
  };
  expect_every_one_refused("V2.txt", good, broken, [&] { sim::read_tum(path("V2.txt")); });
  write("V2.txt", {good[1], good[2]});
  expect_input_error([&] { sim::read_tum(path("V2.txt")); }, path("V2.txt") + ":2", "expected at least 3 poses");
}

Vector3d random_vector(Random& random, double scale = 1) {
  Vector3d v;
  for (double& entry : v) entry = scale * random.uniform(-1, 1);  // in this order, unlike arguments of a call
  return v;
}

Eigen::Matrix3d random_rotation(Random& random) {
  Eigen::Vector4d q(0, 0, 0, 0);
  while (q.norm() < 0.1) q << random_vector(random), random.uniform(-1, 1);
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

sim::Similarity random_similarity(Random& random) {
  return {std::exp(random.uniform(-2, 2)), random_rotation(random), random_vector(random, 10)};
}

Matrix3Xd transformed(const sim::Similarity& s, const Matrix3Xd& points) {
  return (s.scale * product(s.R, points)).colwise() + s.t;
}

// Horn, Closed-form solution of absolute orientation using unit quaternions, 1987.
sim::Similarity horn(const Matrix3Xd& from, const Matrix3Xd& to) {
  const Vector3d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  const Matrix3Xd p = from.colwise() - from_mean, q = to.colwise() - to_mean;
  const Eigen::Matrix3d M = product(p, q.transpose());
  Eigen::Matrix4d N;
  N << M.trace(), M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0),                    //
      M(1, 2) - M(2, 1), M(0, 0) - M(1, 1) - M(2, 2), M(0, 1) + M(1, 0), M(2, 0) + M(0, 2),   //
      M(2, 0) - M(0, 2), M(0, 1) + M(1, 0), -M(0, 0) + M(1, 1) - M(2, 2), M(1, 2) + M(2, 1),  //
      M(0, 1) - M(1, 0), M(2, 0) + M(0, 2), M(1, 2) + M(2, 1), -M(0, 0) - M(1, 1) + M(2, 2);
  const Eigen::Vector4d w = spectrum(N).vectors.col(3);
  sim::Similarity s;
  s.R = Eigen::Quaterniond(w[0], w[1], w[2], w[3]).normalized().toRotationMatrix();
  s.scale = q.cwiseProduct(product(s.R, p)).sum() / p.squaredNorm();
  s.t = to_mean - s.scale * s.R * from_mean;
  return s;
}

Matrix3Xd positions_of(const Poses& poses) {
  Matrix3Xd positions(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = poses[i].T_wb.translation();
  }
  return positions;
}

// The definition, by 4 x 4 matrices, general inverses, every pair of poses, and Horn's alignment.
sim::TrajectoryErrors errors_by_definition(const Poses& estimate, const Poses& truth, double window) {
  const sim::Similarity s = horn(positions_of(estimate), positions_of(truth));
  const Matrix3Xd positions = transformed(s, positions_of(estimate));
  const auto aligned = [&](std::size_t i) {
    Eigen::Matrix4d P = Eigen::Matrix4d::Identity();
    P.topLeftCorner<3, 3>() = s.R * estimate[i].T_wb.linear();
    P.topRightCorner<3, 1>() = positions.col(static_cast<Eigen::Index>(i));
    return P;
  };
  sim::TrajectoryErrors errors;
  errors.ate_m = std::sqrt((positions - positions_of(truth)).colwise().squaredNorm().mean());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (std::size_t j = i + 1; j < truth.size(); ++j) {
      const double time = truth[j].time - truth[i].time;
      if (time < window - 0.5e-6) continue;
      if (time <= window + 0.5) {
        const Eigen::Matrix4d true_motion = product(inverse(truth[i].T_wb.matrix()), truth[j].T_wb.matrix());
        const Eigen::Matrix4d drift = product(inverse(true_motion), product(inverse(aligned(i)), aligned(j)));
        errors.rpe_m_per_s += drift.topRightCorner<3, 1>().norm() / time;
        errors.roe_deg_per_s +=
            sim::degrees * Eigen::AngleAxisd(Eigen::Matrix3d(drift.topLeftCorner<3, 3>())).angle() / time;
        ++errors.windows;
      }
      break;
    }
  }
  errors.rpe_m_per_s /= static_cast<double>(errors.windows);
  errors.roe_deg_per_s /= static_cast<double>(errors.windows);
  return errors;
}

TEST(TrajectoryErrors, are_those_of_the_definition) {
  TracedRandom random;
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    Poses truth = flight(12).poses;
    for (auto& pose : truth) pose.time += 1403636580.83856 + random.uniform(-0.02, 0.02);
    // Missing poses: single ones, and several in a row.
    for (int i = 0; i < 20; ++i) truth.erase(truth.begin() + random.integer(0, static_cast<int>(truth.size()) - 1));
    const auto gap = truth.begin() + random.integer(60, 120);
    truth.erase(gap, gap + random.integer(5, 40));
    const double noise = random.uniform(0, 0.5), window = random.uniform(0.5, 4);
    const sim::Similarity moved = random_similarity(random);
    Poses estimate = truth;
    for (sim::StampedPose& pose : estimate) {
      const Vector3d off = random_vector(random, noise), turn = random_vector(random, noise);
      pose.T_wb = Eigen::Translation3d(Vector3d(transformed(moved, Vector3d(pose.T_wb.translation() + off)))) *
                  Eigen::Quaterniond(Eigen::Matrix3d(moved.R * pose.T_wb.linear())) *
                  Eigen::AngleAxisd(turn.norm(), turn.normalized());
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
