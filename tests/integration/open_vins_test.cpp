// SPDX-License-Identifier: MIT
// The guide's code for OpenVINS, run: JPL quaternions, the newest clone, and Jacobians projected onto a null space.
#include "tests/decompositions.hpp"
#include "tests/integration/open_vins_snippets.hpp"

#include "tests/integration/oracle.hpp"
#include "tests/linear_algebra.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace maxlogdet::test {
namespace {

using ov_type::PoseJPL;
using Features = std::vector<std::shared_ptr<ov_core::Feature>>;

Eigen::Vector4d random_quaternion(Random& random) {
  return (Eigen::Vector4d() << random_vector(random, 1), random.uniform(0.5, 1)).finished().normalized();
}

struct World {
  explicit World(Random& random, std::size_t n, int clones = 3) {
    state._calib_IMUtoCAM[0] = std::make_shared<PoseJPL>(random_quaternion(random), random_vector(random, 0.2));
    for (int i = 0; i < clones; ++i) {
      state._clones_IMU[100 + 0.1 * i] = std::make_shared<PoseJPL>(random_quaternion(random), random_vector(random, 2));
    }
    for (std::size_t i = 0; i < n; ++i) {
      features.push_back(std::make_shared<ov_core::Feature>());
      features.back()->featid = i;
      features.back()->p_FinG = in_world(random_point_in_camera(random));
    }
  }

  // OpenVINS's own chain, and back: p_FinI = R_GtoI (p_FinG - p_IinG), p_FinC = R_ItoC p_FinI + p_IinC.
  Eigen::Vector3d in_camera(const Eigen::Vector3d& p_FinG) const {
    const PoseJPL& clone = *state._clones_IMU.rbegin()->second;
    const PoseJPL& extrinsics = *state._calib_IMUtoCAM.at(0);
    return extrinsics.Rot() * (clone.Rot() * (p_FinG - clone.pos())) + extrinsics.pos();
  }
  Eigen::Vector3d in_world(const Eigen::Vector3d& p_FinC) const {
    const PoseJPL& clone = *state._clones_IMU.rbegin()->second;
    const PoseJPL& extrinsics = *state._calib_IMUtoCAM.at(0);
    return clone.Rot().transpose() * (extrinsics.Rot().transpose() * (p_FinC - extrinsics.pos())) + clone.pos();
  }
  std::vector<SeenPoint> seen() const {
    std::vector<SeenPoint> points;
    for (const auto& feature : features) points.push_back({in_camera(feature->p_FinG), 0, 1, 1, 1.0 / 460});
    return points;
  }

  ov_msckf::State state;
  Features features;
};

// A frame turned by an angle a about z sees the world turned by -a: that is what JPL's q_GtoI stands for.
TEST(OpenVinsGuide, a_jpl_quaternion_rotates_the_frame_not_the_vector) {
  const double a = 0.3;
  const Eigen::Vector4d q(0, 0, std::sin(a / 2), std::cos(a / 2));
  Eigen::Matrix3d expected;
  expected << std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1;
  EXPECT_LT((ov_msckf::jpl_rotation(q) - expected).norm(), 1e-12);
  EXPECT_LT((PoseJPL(q, Eigen::Vector3d::Zero()).Rot() - expected).norm(), 1e-12);

  Random random;
  SCOPED_TRACE(random.name());
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector4d other = random_quaternion(random);
    const Eigen::Matrix3d R = PoseJPL(other, Eigen::Vector3d::Zero()).Rot();
    EXPECT_LT((ov_msckf::jpl_rotation(other) - R).norm(), 1e-12);
  }
}

TEST(OpenVinsGuide, blocks_are_derivatives_at_the_newest_clone_and_a_hamilton_reading_is_not) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 100);
  GoodFeatures good(1000);
  ASSERT_TRUE(ov_msckf::build_blocks(world.state, world.features, good));
  EXPECT_LT(largest_difference(good.blocks, world.seen()), 1e-5);

  // With the clone's quaternion read as Hamilton's, R_ItoG for R_GtoI, it must not pass.
  const PoseJPL& clone = *world.state._clones_IMU.rbegin()->second;
  const PoseJPL& extrinsics = *world.state._calib_IMUtoCAM.at(0);
  const Eigen::Matrix3d R = extrinsics.Rot() * clone.Rot().transpose();
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> wrong;
  wrong << R, extrinsics.pos() - R * clone.pos();
  ASSERT_TRUE(good.build({1, 1, 0, 0, 0}, wrong.data()));
  EXPECT_GT(largest_difference(good.blocks, world.seen()), 0.1);
}

TEST(OpenVinsGuide, selected_features_and_those_without_a_block_are_kept_and_none_is_deleted) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 120);
  world.features[5]->p_FinG = world.in_world({1, 0, -5});  // behind camera 0
  GoodFeatures good(1000);
  ASSERT_TRUE(ov_msckf::build_blocks(world.state, world.features, good));
  Options options;
  options.budget = 40;
  std::set<std::size_t> expected;
  for (const auto i : good.selector.select(good.blocks, options)) expected.insert(i);

  Features features = world.features;
  ov_msckf::UpdaterMSCKF updater;
  updater.update(std::make_shared<ov_msckf::State>(world.state), features);
  std::set<std::size_t> kept;
  for (const auto& feature : features) kept.insert(feature->featid);
  EXPECT_EQ(expected.size(), 40U);
  EXPECT_EQ(expected.count(5), 0U);
  expected.insert(5);
  EXPECT_EQ(kept, expected);
  for (const auto& feature : world.features) EXPECT_FALSE(feature->to_delete);
}

TEST(OpenVinsGuide, all_features_are_kept_when_there_is_no_selection) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 120);
  Features features = world.features;
  GoodFeatures small(50);
  ov_msckf::keep_selected(world.state, features, 40, small);
  EXPECT_EQ(features, world.features) << "more features than the selector has room for";
  GoodFeatures good(1000);
  ov_msckf::keep_selected(world.state, features, 120, good);
  EXPECT_EQ(features, world.features) << "no more than the budget";
  world.state._clones_IMU.clear();
  ov_msckf::keep_selected(world.state, features, 40, good);
  EXPECT_EQ(features, world.features) << "no clone";
}

// A feature seen by several clones, each with `cameras` cameras. Columns: six of each clone, in OpenVINS's error state
// (JPL rotation on the left of R_GtoI, position), by central differences.
Eigen::MatrixXd projected_jacobian(Random& random, int clones, int cameras) {
  struct Pose {
    Eigen::Matrix3d R;
    Eigen::Vector3d p;
  };
  std::vector<Pose> imu(static_cast<std::size_t>(clones)), extrinsics(static_cast<std::size_t>(cameras));
  for (Pose& pose : imu)
    pose = {sim::exp_se3((sim::Vector6() << Eigen::Vector3d::Zero(), random_vector(random, 0.2)).finished()).linear(),
            random_vector(random, 1)};
  for (Pose& pose : extrinsics)
    pose = {sim::exp_se3((sim::Vector6() << Eigen::Vector3d::Zero(), random_vector(random, 0.2)).finished()).linear(),
            random_vector(random, 0.2)};
  const Eigen::Vector3d point = random_point_in_camera(random) + Eigen::Vector3d(0, 0, 3);
  const auto measure = [&](const Eigen::Vector3d& p, const std::vector<Pose>& at) {
    Eigen::VectorXd z(2 * clones * cameras);
    Eigen::Index row = 0;
    for (const Pose& pose : at) {
      for (const Pose& camera : extrinsics) {
        const Eigen::Vector3d p_c = camera.R * (pose.R * (p - pose.p)) + camera.p;
        z.segment<2>(row) = 458 * p_c.head<2>() / p_c.z();
        row += 2;
      }
    }
    return z;
  };
  constexpr double step = 1e-6;
  Eigen::MatrixXd H_f(2 * clones * cameras, 3), H_x(2 * clones * cameras, 6 * clones);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(i);
    H_f.col(i) = (measure(point + d, imu) - measure(point - d, imu)) / (2 * step);
  }
  for (int i = 0; i < 6 * clones; ++i) {
    const auto moved = [&](double by) {
      std::vector<Pose> at = imu;
      Pose& pose = at[static_cast<std::size_t>(i / 6)];
      const Eigen::Vector3d d = by * Eigen::Vector3d::Unit(i % 3);
      if (i % 6 >= 3) {
        pose.p += d;
      } else {
        pose.R = sim::exp_se3((sim::Vector6() << Eigen::Vector3d::Zero(), -d).finished()).linear() * pose.R;
      }
      return measure(point, at);
    };
    H_x.col(i) = (moved(step) - moved(-step)) / (2 * step);
  }
  const Eigen::MatrixXd Q = orthogonal_factor(H_f);
  return product(Q.rightCols(H_f.rows() - 3).transpose(), H_x);
}

TEST(OpenVinsGuide, three_rows_hold_all_that_a_projected_jacobian_says_of_a_clone) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const int cameras : {1, 2, 3}) {
    for (const int clones : {2, 4, 9}) {
      const Eigen::MatrixXd H_x = projected_jacobian(random, clones, cameras);
      const Eigen::Index first = H_x.cols() - 6;
      const double sigma_pix = 1.5;
      const Eigen::MatrixXd H = H_x.middleCols(first, 6) / sigma_pix;
      const Eigen::VectorXd singular = singular_values(H);
      if (singular.size() > 3) {
        EXPECT_LT(singular(3), 1e-6 * singular(0)) << "rank above 3";
      }
      if (cameras >= 2) {
        EXPECT_GT(singular(2), 1e-5 * singular(0)) << "a case without all three rows";
      }

      BlockStore blocks;
      const std::size_t index = ov_msckf::push_back_projected(H_x, first, sigma_pix, blocks);
      ASSERT_TRUE(blocks.is_valid(index));
      const Block block = stored_block(blocks, index);
      EXPECT_LT(relative_difference(gram(block), gram(H)), 1e-5) << cameras << " cameras, " << clones << " clones";
      // The third direction weighs a millionth of the first one: it has to be there too.
      const Eigen::VectorXd stored = singular_values(block);
      for (Eigen::Index i = 0; i < stored.size() && i < singular.size(); ++i) {
        EXPECT_NEAR(stored(i), singular(i), 1e-3 * singular(i) + 1e-6 * singular(0)) << "direction " << i;
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
