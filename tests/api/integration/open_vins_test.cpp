// SPDX-License-Identifier: MIT
// The adapter of OpenVINS and the guide's lines for it: JPL quaternions, the newest clone, the camera's own distortion,
// and Jacobians projected onto a null space.
#include "tests/api/integration/open_vins_snippets.hpp"
#include "tests/support/decompositions.hpp"

#include "tests/api/integration/adapter_world.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace maxlogdet::test {
namespace {

using ov_type::PoseJPL;

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
  }
};

class OpenVinsWorld : public AdapterWorld {
 public:
  OpenVinsWorld(Random& random, std::size_t n, std::size_t budget, std::size_t capacity) {
    updater_.good_features = OpenVins(budget, capacity);
    updater_.good_features.sigma_pixels = 1.5;
    state->_calib_IMUtoCAM[0] = std::make_shared<PoseJPL>(random_quaternion(random), random_vector(random, 0.2));
    state->_cam_intrinsics_cameras[0] = std::make_shared<OddCamera>();
    for (int i = 0; i < 3; ++i) {
      state->_clones_IMU[100 + 0.1 * i] =
          std::make_shared<PoseJPL>(random_quaternion(random), random_vector(random, 2));
    }
    for (std::size_t i = 0; i < n; ++i) {
      features.push_back(std::make_shared<ov_core::Feature>());
      features.back()->featid = i;
      features.back()->p_FinG = T_cw().inverse() * random_point_in_camera(random);
    }
  }

  TrackerHook& hook() override { return updater_.good_features; }

  // What is kept stays in order, and nothing is deleted.
  std::set<std::size_t> run() override {
    std::vector<std::shared_ptr<ov_core::Feature>> offered = features;
    updater_.update(state, offered);
    std::vector<std::size_t> kept;
    for (const auto& feature : offered) kept.push_back(feature->featid);
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    for (const auto& feature : features) EXPECT_FALSE(feature->to_delete);
    return {kept.begin(), kept.end()};
  }

  // By differences of what the camera sees.
  std::vector<Matrix6> informations() const override {
    const auto measure = [](const Eigen::Vector3d& p) {
      return Eigen::VectorXd(OddCamera::distorted(p.head<2>() / p.z()) / 1.5);
    };
    std::vector<Matrix6> all;
    for (const auto& feature : features) {
      all.emplace_back(gram(derivative_under_left_perturbation(measure, T_cw() * feature->p_FinG)));
    }
    return all;
  }

  void lose_pose() override { state->_clones_IMU.clear(); }
  void make_not_finite(std::size_t i) override { features[i]->p_FinG.x() = nan; }
  void put_behind_camera(std::size_t i) override { features[i]->p_FinG = T_cw().inverse() * Eigen::Vector3d(1, 0, -5); }

  // OpenVINS's own chain: p_FinI = R_GtoI (p_FinG - p_IinG), p_FinC = R_ItoC p_FinI + p_IinC.
  sim::Pose T_cw() const {
    const PoseJPL& clone = *state->_clones_IMU.rbegin()->second;
    const PoseJPL& extrinsics = *state->_calib_IMUtoCAM.at(0);
    return transform(extrinsics.Rot(), extrinsics.pos()) * transform(clone.Rot().transpose(), clone.pos()).inverse();
  }

  std::shared_ptr<ov_msckf::State> state = std::make_shared<ov_msckf::State>();
  std::vector<std::shared_ptr<ov_core::Feature>> features;

 private:
  ov_msckf::UpdaterMSCKF updater_;
};

constexpr AdapterCase of_open_vins[] = {{"OpenVins", make_world<OpenVinsWorld>, 1e-5}};
INSTANTIATE_TEST_SUITE_P(OpenVins, AnyAdapter, ::testing::ValuesIn(of_open_vins), name_of);

// A frame turned by an angle a about z sees the world turned by -a: that is what JPL's q_GtoI stands for.
TEST(OpenVinsAdapter, a_jpl_quaternion_rotates_the_frame_not_the_vector) {
  const double a = 0.3;
  const Eigen::Vector4d q(0, 0, std::sin(a / 2), std::cos(a / 2));
  Eigen::Matrix3d expected;
  expected << std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1;
  EXPECT_LT((PoseJPL(q, Eigen::Vector3d::Zero()).Rot() - expected).norm(), 1e-12);
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
