// SPDX-License-Identifier: MIT
// The adapter of OpenVINS and the guide's lines for it: JPL quaternions, the newest clone, the camera's own distortion,
// and Jacobians projected onto a null space.
#include "tests/api/integration/open_vins_snippets.hpp"
#include "tests/support/decompositions.hpp"

#include "tests/api/integration/oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

namespace maxlogdet::test {
namespace {

using ov_type::PoseJPL;
using Features = std::vector<std::shared_ptr<ov_core::Feature>>;

Eigen::Vector4d random_quaternion(Random& random) {
  return (Eigen::Vector4d() << random_vector(random, 1), random.uniform(0.5, 1)).finished().normalized();
}

// With a distortion of no library's model: u depends on y, too.
class OddCamera : public ov_core::CamBase {
 public:
  static Eigen::Vector2d distorted(const Eigen::Vector2d& n) {
    const double rho = n.squaredNorm();
    return {458 * n.x() * (1 - 0.1 * rho) + 20 * n.y() + 367, 457 * n.y() * (1 - 0.1 * rho) + 248};
  }
  void compute_distort_jacobian(const Eigen::Vector2d& uv_norm, Eigen::MatrixXd& H_dz_dzn,
                                Eigen::MatrixXd& H_dz_dzeta) override {
    const double x = uv_norm.x(), y = uv_norm.y(), radial = 1 - 0.1 * (x * x + y * y);
    H_dz_dzn.resize(2, 2);
    H_dz_dzn << 458 * (radial - 0.2 * x * x), 458 * -0.2 * x * y + 20, 457 * -0.2 * x * y, 457 * (radial - 0.2 * y * y);
    H_dz_dzeta.setZero(2, 8);
    ++calls;
  }
  int calls = 0;
};

struct World {
  explicit World(Random& random, std::size_t n, int clones = 3) {
    state->_calib_IMUtoCAM[0] = std::make_shared<PoseJPL>(random_quaternion(random), random_vector(random, 0.2));
    state->_cam_intrinsics_cameras[0] = camera;
    for (int i = 0; i < clones; ++i) {
      state->_clones_IMU[100 + 0.1 * i] =
          std::make_shared<PoseJPL>(random_quaternion(random), random_vector(random, 2));
    }
    for (std::size_t i = 0; i < n; ++i) {
      features.push_back(std::make_shared<ov_core::Feature>());
      features.back()->featid = i;
      features.back()->p_FinG = in_world(random_point_in_camera(random));
    }
  }

  // OpenVINS's own chain, and back: p_FinI = R_GtoI (p_FinG - p_IinG), p_FinC = R_ItoC p_FinI + p_IinC.
  Eigen::Vector3d in_camera(const Eigen::Vector3d& p_FinG) const {
    const PoseJPL& clone = *state->_clones_IMU.rbegin()->second;
    const PoseJPL& extrinsics = *state->_calib_IMUtoCAM.at(0);
    return extrinsics.Rot() * (clone.Rot() * (p_FinG - clone.pos())) + extrinsics.pos();
  }
  Eigen::Vector3d in_world(const Eigen::Vector3d& p_FinC) const {
    const PoseJPL& clone = *state->_clones_IMU.rbegin()->second;
    const PoseJPL& extrinsics = *state->_calib_IMUtoCAM.at(0);
    return clone.Rot().transpose() * (extrinsics.Rot().transpose() * (p_FinC - extrinsics.pos())) + clone.pos();
  }

  // By differences of what the camera sees.
  Matrix6 information_of(const ov_core::Feature& feature, double sigma) const {
    const auto measure = [](const Eigen::Vector3d& p) {
      return Eigen::VectorXd(OddCamera::distorted(p.head<2>() / p.z()));
    };
    return gram(derivative_under_left_perturbation(measure, in_camera(feature.p_FinG))) / (sigma * sigma);
  }

  double largest_difference_of(const BlockStore& blocks, double sigma) const {
    double largest = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const Eigen::MatrixXd actual = gram(stored_block(blocks, i));
      largest = std::max(largest, relative_difference(actual, information_of(*features[i], sigma)));
    }
    return largest;
  }

  std::shared_ptr<OddCamera> camera = std::make_shared<OddCamera>();
  std::shared_ptr<ov_msckf::State> state = std::make_shared<ov_msckf::State>();
  Features features;
};

// A frame turned by an angle a about z sees the world turned by -a: that is what JPL's q_GtoI stands for.
TEST(OpenVinsAdapter, a_jpl_quaternion_rotates_the_frame_not_the_vector) {
  const double a = 0.3;
  const Eigen::Vector4d q(0, 0, std::sin(a / 2), std::cos(a / 2));
  Eigen::Matrix3d expected;
  expected << std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1;
  EXPECT_LT((PoseJPL(q, Eigen::Vector3d::Zero()).Rot() - expected).norm(), 1e-12);
}

TEST(OpenVinsAdapter, the_newest_camera_takes_points_from_the_world_to_camera_0) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 50);
  const Eigen::Matrix<double, 3, 4> T_cw = OpenVins::newest_camera(*world.state, 0);
  for (const auto& feature : world.features) {
    const Eigen::Vector3d p = T_cw.leftCols<3>() * feature->p_FinG + T_cw.col(3);
    EXPECT_LT((p - world.in_camera(feature->p_FinG)).norm(), 1e-9);
  }
}

TEST(OpenVinsAdapter, blocks_are_derivatives_at_the_newest_clone_by_the_cameras_own_distortion) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 100);
  OpenVins good(20);
  good.sigma_pixels = 1.5;
  Features offered = world.features;
  good.keep_selected(*world.state, offered);
  ASSERT_EQ(good.features.blocks().size(), 100U);
  EXPECT_EQ(world.camera->calls, 100);
  EXPECT_LT(world.largest_difference_of(good.features.blocks(), 1.5), 1e-5);
  EXPECT_GT(world.largest_difference_of(good.features.blocks(), 1), 0.1);
}

TEST(OpenVinsAdapter, selected_features_and_those_without_a_block_are_kept_in_order_and_none_is_deleted) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 120);
  world.features[5]->p_FinG = world.in_world({1, 0, -5});  // behind camera 0
  ov_msckf::UpdaterMSCKF updater;
  Features features = world.features;
  updater.update(world.state, features);
  const BlockStore& made = updater.good_features.features.blocks();
  ASSERT_EQ(made.size(), 120U);
  EXPECT_FALSE(made.is_valid(5));
  std::set<std::size_t> expected = {5};
  for (const std::uint32_t i : select_indices(made, updater.good_features.options)) expected.insert(i);
  EXPECT_EQ(expected.size(), 41U);
  std::vector<std::size_t> kept;
  for (const auto& feature : features) kept.push_back(feature->featid);
  EXPECT_EQ(kept, std::vector<std::size_t>(expected.begin(), expected.end()));
  for (const auto& feature : world.features) EXPECT_FALSE(feature->to_delete);
  EXPECT_STREQ(updater.good_features.cost().status, "ok");
  EXPECT_EQ(updater.good_features.cost().candidates, 120U);
  EXPECT_EQ(updater.good_features.cost().selected, 41U);
}

// Of the world's features, how many are kept.
std::size_t kept_by(OpenVins good, const World& world, const std::string& why) {
  Features features = world.features;
  good.keep_selected(*world.state, features);
  EXPECT_EQ(good.cost().status, why);
  EXPECT_EQ(good.cost().candidates, world.features.size());
  EXPECT_EQ(good.cost().selected, features.size());
  return features.size();
}

TEST(OpenVinsAdapter, few_features_and_after_an_error_all_are_kept) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 120);
  EXPECT_EQ(kept_by(OpenVins(120), world, "all_selected"), 120U);
  OpenVins good(40);
  good.options.time_limit = -1;
  EXPECT_EQ(kept_by(std::move(good), world, "invalid_time_limit"), 120U);
  world.state->_clones_IMU.clear();
  EXPECT_EQ(kept_by(OpenVins(40), world, "invalid_pose"), 120U);
}

TEST(OpenVinsAdapter, at_a_deadline_the_budget_is_kept_and_beyond_the_capacity_all) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 120);
  OpenVins good(40);
  good.options.time_limit = 1e-9;
  EXPECT_EQ(kept_by(std::move(good), world, "deadline_reached"), 40U);
  EXPECT_EQ(kept_by(OpenVins(40, 50), world, "capacity_exceeded"), 40U + 70);
}

TEST(OpenVinsAdapter, a_feature_that_is_not_finite_is_kept) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 120);
  world.features[7]->p_FinG.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kept_by(OpenVins(40), world, "ok"), 41U);
}

struct Placed {
  Eigen::Matrix3d R;
  Eigen::Vector3d p;
};

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& vector) {
  return sim::exp_se3((sim::Vector6() << Eigen::Vector3d::Zero(), vector).finished()).linear();
}

// What clones measure of a point, each with every camera.
Eigen::VectorXd measured(const Eigen::Vector3d& p, const std::vector<Placed>& clones,
                         const std::vector<Placed>& cameras) {
  Eigen::VectorXd z(2 * static_cast<Eigen::Index>(clones.size() * cameras.size()));
  Eigen::Index row = 0;
  for (const Placed& clone : clones) {
    for (const Placed& camera : cameras) {
      const Eigen::Vector3d p_c = camera.R * (clone.R * (p - clone.p)) + camera.p;
      z.segment<2>(row) = 458 * p_c.head<2>() / p_c.z();
      row += 2;
    }
  }
  return z;
}

// Along entry i of OpenVINS's error state: six entries of each clone, JPL rotation on the left of R_GtoI, position.
std::vector<Placed> moved(std::vector<Placed> clones, int i, double by) {
  Placed& clone = clones[static_cast<std::size_t>(i / 6)];
  const Eigen::Vector3d d = by * Eigen::Vector3d::Unit(i % 3);
  if (i % 6 >= 3) {
    clone.p += d;
  } else {
    clone.R = rotation_of(-d) * clone.R;
  }
  return clones;
}

// Of a feature seen by several clones, by central differences; a column each of the error state's entries.
Eigen::MatrixXd projected_jacobian(Random& random, int clone_count, int camera_count) {
  std::vector<Placed> clones(static_cast<std::size_t>(clone_count)), cameras(static_cast<std::size_t>(camera_count));
  for (Placed& clone : clones) clone = {rotation_of(random_vector(random, 0.2)), random_vector(random, 1)};
  for (Placed& camera : cameras) camera = {rotation_of(random_vector(random, 0.2)), random_vector(random, 0.2)};
  const Eigen::Vector3d point = random_point_in_camera(random) + Eigen::Vector3d(0, 0, 3);
  constexpr double step = 1e-6;
  const Eigen::Index rows = 2 * clone_count * camera_count;
  Eigen::MatrixXd H_f(rows, 3), H_x(rows, 6 * clone_count);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(i);
    H_f.col(i) = (measured(point + d, clones, cameras) - measured(point - d, clones, cameras)) / (2 * step);
  }
  for (int i = 0; i < 6 * clone_count; ++i) {
    const Eigen::VectorXd difference =
        measured(point, moved(clones, i, step), cameras) - measured(point, moved(clones, i, -step), cameras);
    H_x.col(i) = difference / (2 * step);
  }
  const Eigen::MatrixXd Q = orthogonal_factor(H_f);
  return product(Q.rightCols(H_f.rows() - 3).transpose(), H_x);
}

TEST(OpenVinsAdapter, three_rows_hold_all_that_a_projected_jacobian_says_of_a_clone) {
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
      const std::size_t index = push_back_projected(H_x, first, sigma_pix, blocks);
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
