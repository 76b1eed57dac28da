// SPDX-License-Identifier: MIT
// The guide's code that belongs to no tracker, run: priors, weights, one memory a thread; and what it says of budgets
// and weightings. guide_frame_test.cpp has the rest.
#include "tests/api/integration/general_snippets.hpp"

#include "bench/world/scene.hpp"
#include "bench/world/se3.hpp"
#include "tests/api/integration/oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <cmath>
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

TEST(PriorGuide, body_poses_perturbed_in_the_body_or_in_the_world) {
  Random random;
  SCOPED_TRACE(random.name());
  for (int n = 0; n < 10; ++n) {
    const Pose T_cb = test::random_pose(random);
    const Pose T_wb = test::random_pose(random);
    const Pose T_cw = T_cb * T_wb.inverse();
    const Matrix6 covariance = random_prior(random);

    const Matrix6 in_body = jacobian_of(T_cw, [&](const Vector6& d) {
      const Pose moved = transform(T_wb.linear() * rotation(d.tail<3>()), T_wb.translation() + d.head<3>());
      return Pose(T_cb * moved.inverse());
    });
    const Eigen::Matrix3d R_cw = T_cw.linear();
    const Matrix6 prior = prior_of_body_pose(covariance, T_cb.translation(), R_cw, T_cb.linear());
    expect_same_information(prior, covariance, in_body);

    const Matrix6 in_world = jacobian_of(T_cw, [&](const Vector6& d) {
      const Pose moved = transform(rotation(d.tail<3>()) * T_wb.linear(), T_wb.translation() + d.head<3>());
      return Pose(T_cb * moved.inverse());
    });
    expect_same_information(prior_of_body_pose(covariance, T_cb.translation(), R_cw, R_cw), covariance, in_world);
  }
}

void gather(const sim::Frame& frame, GoodFeatures& good) {
  good.start(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()));
  for (const sim::Match& m : frame.matches) {
    const double uv[2] = {m.u, m.v};
    FeatureMatch match(m.point, uv, 1 / std::sqrt(m.inv_sigma2));
    match.u_right = m.u_right;
    good.add(match);
  }
}

TEST(BudgetGuide, of_synthetic_frames_100_of_1000_matches_keep_a_fifth_to_a_third_of_the_information) {
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 1000, Random().seed());
  GoodFeatures good(1000);
  gather(frame, good);
  ASSERT_EQ(good.select(100).status, Status::ok);
  EXPECT_GT(efficiency(good), 0.2);
  EXPECT_LT(efficiency(good), 0.34);
}

// Points that were seen once in stereo, and their covariances.
struct StereoMap {
  PinholeCamera camera = {718, 718, 607, 185, 386};
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Matrix3d> covariances;
};

// 6 to 400 m away, as many of each disparity as of any other.
StereoMap random_stereo_map(Random& random, std::size_t n) {
  StereoMap map;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = map.camera.bf / random.uniform(1, 60);
    const double x = random.uniform(-0.8, 0.8) * z;
    const double y = random.uniform(-0.2, 0.2) * z;
    map.points.emplace_back(x, y, z);
    PointCovariance point(map.points.back().data());
    point.observe(map.camera, RigidTransform::identity(), 1, true);
    map.covariances.emplace_back();
    EXPECT_TRUE(point.covariance(map.covariances.back().data()));
  }
  return map;
}

// What 50 selected points tell, errors of the map and of measurements counted, nats.
double log_det_of_selected(const StereoMap& map, bool with_covariances) {
  GoodFeatures good(map.points.size());
  good.block_options.weighting = with_covariances ? Weighting::measurement : Weighting::map_bias;
  good.start(map.camera, RigidTransform::identity());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    FeatureMatch match(map.points[i]);
    match.u_right = 0;  // which rows there are; their values change no block
    if (with_covariances) match.covariance = map.covariances[i].data();
    good.add(match);
  }
  EXPECT_EQ(good.select(50).status, Status::ok);
  Matrix6 information = Matrix6::Zero();
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    if (!good.is_selected(i)) continue;
    information += information_of({map.points[i], map.camera.bf, map.camera.fx, map.camera.fy, 1, map.covariances[i]});
  }
  return log_det(information);
}

TEST(WeightingGuide, of_a_stereo_map_covariances_select_the_points_that_tell_more_of_the_pose) {
  Random random;
  SCOPED_TRACE(random.name());
  for (int world = 0; world < 40; ++world) {
    const StereoMap map = random_stereo_map(random, 300);
    EXPECT_GT(log_det_of_selected(map, true), log_det_of_selected(map, false)) << "world " << world;
  }
}

TEST(WeightingGuide, rows_that_are_weighed_have_the_information_of_the_blocks) {
  Random random;
  SCOPED_TRACE(random.name());
  const PinholeCamera camera = {458, 457, 367, 248};
  const double covariance[9] = {0.2, 0.01, 0, 0.01, 0.3, 0, 0, 0, 0.5};
  const SeenPoint seen = {
      random_point_in_camera(random), 0, camera.fx, camera.fy, 2, Eigen::Map<const Eigen::Matrix3d>(covariance)};
  GoodFeatures good(1);
  good.start(camera, RigidTransform::identity());
  FeatureMatch match(seen.p_c, 2);
  match.covariance = covariance;
  good.add(match);
  const Eigen::Matrix<double, 2, 6> before = Derivatives(seen).H_x.topRows<2>();
  Eigen::Matrix<double, 2, 6> H = before;
  Eigen::Vector2d e(1, 2);
  guide::weigh_rows(good, 0, 2, e, H);
  EXPECT_LT(relative_difference(gram(H), information_of(seen)), 1e-6);
  // e is whitened alike.
  Eigen::Matrix<double, 2, 2, Eigen::RowMajor> W;
  ASSERT_TRUE(match_whitening(good, 0, W.data()));
  EXPECT_LT(relative_difference(e, product(W, Eigen::Vector2d(1, 2))), 1e-12);
  H = before;
  guide::weigh_rows(good, 1, 2, e, H);  // there is none
  EXPECT_LT(relative_difference(H, before / 2), 1e-12);
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
