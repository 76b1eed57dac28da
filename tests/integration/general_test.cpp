// SPDX-License-Identifier: MIT
// The guide's code that belongs to no tracker, run: weightings, covariances, priors, budgets, one memory a thread.
#include "tests/decompositions.hpp"
#include "tests/integration/general_snippets.hpp"

#include "sim/scene.hpp"
#include "sim/se3.hpp"
#include "tests/integration/oracle.hpp"
#include "tests/linear_algebra.hpp"
#include "tests/support.hpp"

#include <cstdint>
#include <set>
#include <thread>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Pose;

// d xi / d delta of  T_cw(delta) = exp(xi^) T_cw,  by central differences.
template <class Perturb>
Matrix6 jacobian_of(const Pose& T_cw, const Perturb& perturbed) {
  constexpr double step = 1e-6;
  Matrix6 A;
  for (int i = 0; i < 6; ++i) {
    const Vector6 d = step * Vector6::Unit(i);
    A.col(i) =
        (sim::log_se3(perturbed(d) * T_cw.inverse()) - sim::log_se3(perturbed(-d) * T_cw.inverse())) / (2 * step);
  }
  return A;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& vector) {
  return sim::exp_se3((Vector6() << Eigen::Vector3d::Zero(), vector).finished()).linear();
}

Pose transform(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Pose T = Pose::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

void expect_same_information(const Matrix6& prior, const Matrix6& covariance, const Matrix6& A) {
  EXPECT_LT(relative_difference(prior, inverse(product(product(A, covariance), A.transpose()))), 1e-5);
}

TEST(PriorGuide, g2o_counts_rotation_first) {
  Random random;
  SCOPED_TRACE(random.name());
  const Pose T_cw = test::random_pose(random);
  const Matrix6 hessian = random_prior(random);
  const Matrix6 A = jacobian_of(T_cw, [&](const Vector6& d) {  // d = (rotation, translation)
    return Pose(sim::exp_se3((Vector6() << d.tail<3>(), d.head<3>()).finished()) * T_cw);
  });
  expect_same_information(prior_of_g2o(hessian), inverse(hessian), A);
  EXPECT_GT((prior_of_g2o(hessian) - hessian).norm(), 0.1 * hessian.norm());
}

TEST(PriorGuide, body_poses_of_vins_fusion_openvins_and_basalt) {
  Random random;
  SCOPED_TRACE(random.name());
  for (int n = 0; n < 10; ++n) {
    const Pose T_cb = test::random_pose(random);
    const Pose T_wb = test::random_pose(random);
    const Pose T_cw = T_cb * T_wb.inverse();
    const Matrix6 covariance = random_prior(random);

    const Matrix6 vins = jacobian_of(T_cw, [&](const Vector6& d) {
      const Pose moved = transform(T_wb.linear() * rotation(d.tail<3>()), T_wb.translation() + d.head<3>());
      return Pose(T_cb * moved.inverse());
    });
    const Eigen::Matrix3d R_cw = T_cw.linear();
    const Matrix6 prior = prior_of_body_pose(covariance, T_cb.translation(), R_cw, T_cb.linear());
    expect_same_information(prior, covariance, vins);

    const Matrix6 openvins = jacobian_of(T_cw, [&](const Vector6& d) {  // a JPL error: R_GtoI <- (I - [d]x) R_GtoI
      const Eigen::Matrix3d R_GtoI = rotation(-d.tail<3>()) * T_wb.linear().transpose();
      return Pose(T_cb * transform(R_GtoI.transpose(), T_wb.translation() + d.head<3>()).inverse());
    });
    expect_same_information(prior, covariance, openvins);

    const Matrix6 basalt = jacobian_of(T_cw, [&](const Vector6& d) {
      const Pose moved = transform(rotation(d.tail<3>()) * T_wb.linear(), T_wb.translation() + d.head<3>());
      return Pose(T_cb * moved.inverse());
    });
    expect_same_information(prior_of_body_pose(covariance, T_cb.translation(), R_cw, R_cw), covariance, basalt);
  }
}

double log_det_of_all(const BlockStore& blocks) {
  Matrix6 information = 1e-5 * Matrix6::Identity();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block H = stored_block(blocks, i);
    information += gram(H);
  }
  return log_det(information);
}

TEST(BudgetGuide, the_share_compares_the_selection_with_all_matches) {
  GoodFeatures good(2000);
  BlockOptions options;
  options.weighting = Weighting::measurement;
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 1000, Random().seed());
  ASSERT_EQ(build_blocks(frame, options, good.blocks).status, BlockStatus::ok);
  const double log_det = good.selector.select(good.blocks, Options()).log_det;
  const double share = share_of_all(good, log_det);
  EXPECT_NEAR(share, std::exp((log_det - log_det_of_all(good.blocks)) / 6), 1e-6);
  // What the guide says of 100 of 1000: a fifth to a third, and a random one would have a tenth.
  EXPECT_GT(share, 0.2);
  EXPECT_LT(share, 0.34);
}

// Measured from a few places with noise of a known deviation, and triangulated by least squares, a point scatters as
// the inverse of its information says.
TEST(PointCovarianceGuide, is_the_scatter_of_triangulated_points) {
  Random random;
  SCOPED_TRACE(random.name());
  const Eigen::Vector3d p_w(0.7, -0.4, 8);
  const double sigma = 0.1;  // small against the disparity: the covariance is one of first order
  for (const double bf : {0.0, 50.0}) {
    std::vector<Pose> poses;
    Eigen::Matrix3d information = information_of_new_point();
    for (int k = 0; k < (bf > 0 ? 1 : 3); ++k) {  // one stereo observation, or three of one camera
      sim::Vector6 xi;
      xi << random_vector(random, 0.6), random_vector(random, 0.1);
      poses.push_back(sim::exp_se3(xi));
      information += information_of_point({458, 457, 367, 248, bf}, poses.back().matrix().topRows<3>(), p_w, sigma);
    }
    const Eigen::Index rows = bf > 0 ? 3 : 2;
    const auto measure = [&](const Eigen::Vector3d& p) {
      Eigen::VectorXd z(rows * static_cast<Eigen::Index>(poses.size()));
      for (std::size_t k = 0; k < poses.size(); ++k) {
        const Eigen::Vector3d p_c = poses[k] * p;
        const double u = 458 * p_c.x() / p_c.z();
        const Eigen::Vector3d all(u, 457 * p_c.y() / p_c.z(), u - bf / p_c.z());
        z.segment(rows * static_cast<Eigen::Index>(k), rows) = all.head(rows);
      }
      return z;
    };
    const Eigen::VectorXd exact = measure(p_w);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    constexpr int draws = 3000;
    for (int draw = 0; draw < draws; ++draw) {
      Eigen::VectorXd z = exact;
      for (double& value : z) value += std::sqrt(3.0) * sigma * random.uniform(-1, 1);
      Eigen::Vector3d p = p_w;
      for (int iteration = 0; iteration < 4; ++iteration) {
        Eigen::MatrixXd H(z.size(), 3);
        for (int i = 0; i < 3; ++i) {
          const Eigen::Vector3d d = 1e-6 * Eigen::Vector3d::Unit(i);
          H.col(i) = (measure(p + d) - measure(p - d)) / 2e-6;
        }
        p += least_squares(H, z - measure(p));
      }
      scatter += (p - p_w) * (p - p_w).transpose() / draws;
    }
    const Eigen::Matrix3d L = cholesky(information);
    EXPECT_LT((L.transpose() * scatter * L - Eigen::Matrix3d::Identity()).norm(), 0.2) << "bf " << bf;
  }
}

TEST(PointCovarianceGuide, a_point_behind_the_camera_adds_nothing) {
  const Eigen::Matrix<double, 3, 4> T_cw = Eigen::Matrix<double, 3, 4>::Identity();
  EXPECT_EQ(information_of_point({458, 457, 367, 248, 50}, T_cw, {0, 0, -3}, 1).norm(), 0);
}

// 300 points seen once in stereo, 6 to 400 m away, as many of each disparity as of any other.
TEST(WeightingGuide, of_a_stereo_map_covariances_select_the_points_that_tell_more_of_the_pose) {
  Random random;
  SCOPED_TRACE(random.name());
  const PinholeCamera camera = {718, 718, 607, 185, 386};
  const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> T_cw = Eigen::Matrix<double, 3, 4>::Identity();
  for (int world = 0; world < 40; ++world) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 300; ++i) {
      const double z = camera.bf / random.uniform(1, 60);
      const double x = random.uniform(-0.8, 0.8) * z;
      const double y = random.uniform(-0.2, 0.2) * z;
      points.emplace_back(x, y, z);
    }
    // What 50 selected ones tell, errors of the map and of measurements counted, nats.
    const auto log_det = [&](bool with_covariances) {
      GoodFeatures good(300);
      good.without_covariances = Weighting::map_bias;
      good.start(points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d& p = points[i];
        const Eigen::Matrix3d information = information_of_new_point() + information_of_point(camera, T_cw, p, 1);
        const Eigen::Matrix3d covariance = information.inverse();
        good.set(i, p.x(), p.y(), p.z(), 1, true, with_covariances ? covariance.data() : nullptr);
      }
      EXPECT_TRUE(good.build(camera, T_cw.data()));
      Options options;
      options.budget = 50;
      Matrix6 information = Matrix6::Zero();
      for (const auto i : good.selector.select(good.blocks, options)) {
        const Eigen::Matrix3d known = information_of_new_point() + information_of_point(camera, T_cw, points[i], 1);
        information += information_of({points[i], camera.bf, camera.fx, camera.fy, 1, known.inverse()});
      }
      return test::log_det(information);
    };
    EXPECT_GT(log_det(true), log_det(false)) << "world " << world;
  }
}

TEST(WeightingGuide, beside_matches_with_a_covariance_one_without_is_no_candidate) {
  const double covariance[9] = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
  const double T_cw[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  GoodFeatures good(2);
  good.start(2);
  good.set(0, 0, 0, 5, 1, false, covariance);
  good.set(1, 1, 0, 5, 1, false);
  good.required = {1, 1};
  ASSERT_TRUE(good.build({458, 457, 367, 248, 0}, T_cw));
  EXPECT_TRUE(good.blocks.is_valid(0));
  EXPECT_FALSE(good.blocks.is_valid(1));
  EXPECT_EQ(good.required, (std::vector<unsigned char>{1, 0})) << "what is required has to be valid";
  good.start(2);  // nothing is left of it
  good.set(1, 1, 0, 5, 1, false);
  ASSERT_TRUE(good.build({458, 457, 367, 248, 0}, T_cw));
  EXPECT_TRUE(good.blocks.is_valid(1));
}

TEST(ActiveGuide, batches_are_answered_until_enough_are_found) {
  Random random;
  SCOPED_TRACE(random.name());
  BlockStore blocks(300);
  for (int i = 0; i < 300; ++i) blocks.push_back(random_block(random, 2, 1).data(), 2);
  ActiveSelection active(300);
  Options options;
  options.budget = 50;
  ASSERT_EQ(active.start(blocks, options), Status::ok);
  std::vector<std::uint32_t> tried, found;
  match_in_batches(active, [&](const std::uint32_t* indices, std::size_t count, unsigned char* was_found) {
    for (std::size_t j = 0; j < count; ++j) {
      was_found[j] = random.chance(0.5) ? 1 : 0;
      tried.push_back(indices[j]);
      if (was_found[j] != 0) found.push_back(indices[j]);
    }
  });
  EXPECT_EQ(found.size(), 50U);
  EXPECT_EQ(std::set<std::uint32_t>(tried.begin(), tried.end()).size(), tried.size()) << "one was tried twice";
  const Selection selection = active.selection();
  EXPECT_EQ(std::vector<std::uint32_t>(selection.begin(), selection.end()), found);
}

TEST(ThreadsGuide, each_thread_has_its_own_memory) {
  const GoodFeatures* other = nullptr;
  const GoodFeatures* const mine = &good_features_of_this_thread();
  std::thread([&] { other = &good_features_of_this_thread(); }).join();
  EXPECT_NE(other, mine);
  EXPECT_EQ(mine, &good_features_of_this_thread());
}

}  // namespace
}  // namespace maxlogdet::test
