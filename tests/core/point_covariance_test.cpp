// SPDX-License-Identifier: MIT
// Covariances of map points against the inverse of what observations tell.
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/random_isometry.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/point_covariance.hpp>

#include <array>
#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

using Pose = Eigen::Isometry3d;

constexpr PinholeCamera stereo_camera = {458, 457, 367, 248, 50};

// (u, v, u_right).
WideMatrix seen(const PinholeCamera& camera, const Pose& T_cw, const WideMatrix& p_w) {
  const WideMatrix p = wide_product(T_cw.linear().cast<long double>(), p_w) + T_cw.translation().cast<long double>();
  WideMatrix z(3, 1);
  z << camera.fx * p(0) / p(2), camera.fy * p(1) / p(2), (camera.fx * p(0) - camera.bf) / p(2);
  return z;
}

// By central differences.
WideMatrix information_of(const PinholeCamera& camera, const Pose& T_cw, const Eigen::Vector3d& p_w, double sigma,
                          bool is_stereo) {
  const long double step = 1e-6L;
  WideMatrix H(3, 3);
  for (int i = 0; i < 3; ++i) {
    WideMatrix d = WideMatrix::Zero(3, 1);
    d(i) = step;
    const WideMatrix p = p_w.cast<long double>();
    H.col(i) = (seen(camera, T_cw, p + d) - seen(camera, T_cw, p - d)) / (2 * step * sigma);
  }
  return wide_gram(H.topRows(is_stereo ? 3 : 2));
}

TEST(PointCovariance, is_the_inverse_of_what_the_observations_tell) {
  for_each_trial(100, [&](Random& random) {
    const double z = random.uniform(1, 60);
    const Eigen::Vector3d p_w(random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z);
    PointCovariance point(p_w.data());
    WideMatrix information = WideMatrix::Zero(3, 3);
    const int observations = random.integer(1, 12);
    for (int k = 0; k < observations; ++k) {
      const Pose T_cw = random_isometry(random, 0.5, 0.2);
      const double sigma = random.uniform(0.5, 3);
      const bool is_stereo = random.chance(0.5);
      const bool has_right = random.chance(0.8);
      PinholeCamera camera = stereo_camera;
      if (!has_right) camera.bf = 0;
      point.observe(camera, RigidTransform(T_cw.matrix()), sigma, is_stereo);
      information += information_of(camera, T_cw, p_w, sigma, is_stereo && has_right);
    }
    information += 1e-8L * information.trace() * WideMatrix::Identity(3, 3);
    EXPECT_EQ(point.observations(), observations);
    Eigen::Matrix3d covariance;
    ASSERT_TRUE(point.covariance(covariance.data()));
    EXPECT_EQ(covariance, covariance.transpose());
    const WideMatrix expected = wide_inverse(information);
    const WideMatrix difference = covariance.cast<long double>() - expected;
    EXPECT_LT(difference.norm(), 1e-6L * expected.norm());
  });
}

TEST(PointCovariance, takes_points_of_float) {
  const float p_w[3] = {0.5F, 0.25F, 4};
  const double same[3] = {0.5, 0.25, 4};
  double covariance[2][9];
  PointCovariance of_float(p_w), of_double(same);
  for (PointCovariance* point : {&of_float, &of_double}) {
    point->observe(stereo_camera, RigidTransform::identity(), 1, true);
    ASSERT_TRUE(point->covariance(covariance[point == &of_float ? 0 : 1]));
  }
  for (int e = 0; e < 9; ++e) EXPECT_EQ(covariance[0][e], covariance[1][e]);
}

// Along the ray of a single camera it is 10^4 times as long as wide.
TEST(PointCovariance, of_one_camera_alone_leaves_a_near_match_its_block) {
  TracedRandom random;
  for (int i = 0; i < 200; ++i) {
    const double f = random.uniform(200, 2000);
    const double z = random.uniform(0.1, 3);
    const double p_w[3] = {random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z};
    const PinholeCamera camera = {f, f, 0, 0};
    const double sigma = random.uniform(0.3, 3);
    PointCovariance point(p_w);
    point.observe(camera, RigidTransform::identity(), sigma, false);
    double covariance[9];
    ASSERT_TRUE(point.covariance(covariance));
    Matches matches;
    matches.size = 1;
    matches.points = p_w;
    matches.sigmas = &sigma;
    matches.map_covariances = covariance;
    BlockOptions options;
    options.weighting = Weighting::measurement_and_map;
    BlockStore blocks(1);
    const RigidTransform moved =
        RigidTransform::row_major(std::array<double, 12>{1, 0, 0, 0.02, 0, 1, 0, 0, 0, 0, 1, 0}.data());
    for (const RigidTransform& T_cw : {RigidTransform::identity(), moved}) {
      EXPECT_EQ(append_blocks(camera, T_cw, matches, options, blocks).invalid_covariances, 0U) << f << ' ' << z;
    }
  }
}

TEST(PointCovariance, is_not_known_without_observations_or_where_it_is_not_finite) {
  const double behind[3] = {0, 0, -3};
  double covariance[9] = {7};
  PointCovariance point(behind);
  EXPECT_FALSE(point.covariance(covariance));
  point.observe(stereo_camera, RigidTransform::identity(), 1, true);
  EXPECT_EQ(point.observations(), 0) << "behind the camera";
  EXPECT_FALSE(point.covariance(covariance));
  const double in_front[3] = {0, 0, 3};
  for (double sigma = 1e-60; sigma < 1e60; sigma *= 1.7) {  // also where the determinant is denormal
    PointCovariance extreme(in_front);
    extreme.observe(stereo_camera, RigidTransform::identity(), sigma, true);
    EXPECT_EQ(extreme.observations(), 1);
    double entries[9] = {7, 7, 7, 7, 7, 7, 7, 7, 7};
    const bool is_there = extreme.covariance(entries);
    EXPECT_TRUE(is_there || sigma < 1e-40 || sigma > 1e50) << sigma;
    if (is_there) {
      EXPECT_GT(entries[0], 0) << sigma;
    }
    for (const double entry : entries) EXPECT_TRUE(is_there ? std::isfinite(entry) : entry == 7) << sigma;
  }
  const double nowhere[3] = {0, 0, nan};
  PointCovariance lost(nowhere);
  lost.observe(stereo_camera, RigidTransform::identity(), 1, true);
  EXPECT_FALSE(lost.covariance(covariance));
  EXPECT_EQ(covariance[0], 7) << "nothing is written";
}

// What is added to one observation, and changes nothing.
void expect_ignored(const char* what, const PinholeCamera& camera, const RigidTransform& T_cw, double sigma) {
  SCOPED_TRACE(what);
  const double p_w[3] = {0.1, 0.2, 3};
  PointCovariance point(p_w);
  point.observe(stereo_camera, RigidTransform::identity(), 1, true);
  double expected[9], actual[9];
  ASSERT_TRUE(point.covariance(expected));
  point.observe(camera, T_cw, sigma, true);
  EXPECT_EQ(point.observations(), 1);
  ASSERT_TRUE(point.covariance(actual));
  for (int e = 0; e < 9; ++e) EXPECT_EQ(actual[e], expected[e]);
}

TEST(PointCovariance, ignores_observations_by_unusable_numbers) {
  const RigidTransform identity = RigidTransform::identity();
  for (const double sigma : {0.0, -1.0, nan, infinity, 1e-200}) expect_ignored("sigma", stereo_camera, identity, sigma);
  for (double PinholeCamera::*const number :
       {&PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy, &PinholeCamera::bf}) {
    for (const double value : {nan, infinity, -infinity}) {
      PinholeCamera camera = stereo_camera;
      camera.*number = value;
      expect_ignored("camera", camera, identity, 1);
    }
  }
  expect_ignored("fx", {-458, 457, 367, 248, 50}, identity, 1);
  expect_ignored("no pose", stereo_camera, nullptr, 1);
  for (std::size_t e = 0; e < 12; ++e) {
    for (const double value : {nan, infinity, -infinity}) {
      double T_cw[12];
      std::copy_n(identity.data(), 12, T_cw);
      T_cw[e] = value;
      expect_ignored("pose", stereo_camera, RigidTransform::row_major(T_cw), 1);
    }
  }
  PinholeCamera monocular = stereo_camera;
  monocular.bf = nan;
  const double p_w[3] = {0, 0, 3};
  PointCovariance point(p_w);
  point.observe(monocular, identity, 1, false);
  EXPECT_EQ(point.observations(), 1) << "without a stereo row bf is not read";
}

}  // namespace
}  // namespace maxlogdet::test
