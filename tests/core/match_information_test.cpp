// SPDX-License-Identifier: MIT
// The weight of a match against the inverse of its Sigma in long double, and against the blocks: J^T Omega J is their
// H^T H.
#include "bench/world/frame.hpp"
#include "tests/support/block_oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/pose_derivative.hpp"
#include "tests/support/random_isometry.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <maxlogdet/match_information.hpp>

#include <cmath>
#include <functional>
#include <vector>

namespace maxlogdet::test {
namespace {

using Isometry = Eigen::Isometry3d;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// A match of a pinhole.
struct Seen {
  PinholeCamera camera;
  Isometry T_cw;
  Eigen::Vector3d p_w;
  MatchNoise noise;
  RowMajor3 covariance;

  std::size_t rows() const { return residual_rows(noise.depth_cue); }
};

void fill(Random& random, Seen& seen) {
  seen.camera = {random.uniform(200, 800), random.uniform(200, 800), 320, 240, random.uniform(20, 400)};
  seen.T_cw = random_isometry(random, 3, 2);
  const double z = random.uniform(0.5, 60);
  seen.p_w = seen.T_cw.inverse() * Eigen::Vector3d(random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z);
  seen.noise.sigma = random.uniform(0.3, 4);
  seen.noise.depth_cue = thirds[random.integer(0, 2)];
  seen.noise.depth_sigma = random.uniform(0.01, 0.3);
  const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr([&] { return random.uniform(-1, 1); });
  seen.covariance = std::pow(0.05 * z, 2) * root * root.transpose();
  const int kind = random.integer(0, 2);
  if (kind == 0) seen.covariance.setZero();
  if (kind == 1) {
    seen.noise.map_sigma = random.uniform(0, 0.3);
    seen.covariance = std::pow(seen.noise.map_sigma, 2) * Eigen::Matrix3d::Identity();
  }
  if (kind == 2) seen.noise.covariance = seen.covariance.data();
}

// J by p_c; without a third measurement its first two rows.
WideMatrix jacobian_of(const PinholeCamera& camera, const Eigen::Vector3d& p_c, DepthCue depth_cue) {
  const long double x = p_c.x(), y = p_c.y(), z = p_c.z();
  WideMatrix J = WideMatrix::Zero(3, 3);
  J.row(0) << camera.fx / z, 0, -camera.fx * x / (z * z);
  J.row(1) << 0, camera.fy / z, -camera.fy * y / (z * z);
  J.row(2) << 0, 0, 1;
  if (depth_cue == DepthCue::stereo) J.row(2) << camera.fx / z, 0, (camera.bf - camera.fx * x) / (z * z);
  return J.topRows(static_cast<Eigen::Index>(residual_rows(depth_cue)));
}

WideMatrix sigma_of(const Seen& seen) {
  const WideMatrix J = wide_product(jacobian_of(seen.camera, seen.T_cw * seen.p_w, seen.noise.depth_cue),
                                    seen.T_cw.linear().cast<long double>());
  WideMatrix S = wide_product(wide_product(J, seen.covariance.cast<long double>()), J.transpose());
  for (Eigen::Index a = 0; a < S.rows(); ++a) {
    const bool is_depth = a == 2 && seen.noise.depth_cue == DepthCue::depth;
    S(a, a) += std::pow(static_cast<long double>(is_depth ? seen.noise.depth_sigma : seen.noise.sigma), 2);
  }
  return S;
}

Eigen::MatrixXd matrix_of(const double* entries, std::size_t rows) {
  const auto size = static_cast<Eigen::Index>(rows);
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(entries, size, size);
}

// Of a camera alone, and on a rig at the same pose.
TEST(MatchInformation, is_the_inverse_of_the_covariance_of_the_residual) {
  for_each_trial(2000, [&](Random& random) {
    Seen seen;
    fill(random, seen);
    const Isometry T_cb = random_isometry(random, 3, 2);
    Camera on_rig(seen.camera);
    on_rig.T_cb = RigidTransform(T_cb.matrix());
    const Eigen::MatrixXd expected = wide_inverse(sigma_of(seen)).cast<double>();
    const auto expect_weights = [&](const Camera& camera, const Isometry& T) {
      double omega[9], W[9];
      ASSERT_TRUE(match_information(camera, RigidTransform(T.matrix()), seen.p_w.data(), seen.noise, omega));
      ASSERT_TRUE(match_whitening(camera, RigidTransform(T.matrix()), seen.p_w.data(), seen.noise, W));
      const Eigen::MatrixXd information = matrix_of(omega, seen.rows());
      const Eigen::MatrixXd whitening = matrix_of(W, seen.rows());
      EXPECT_EQ(information, information.transpose());
      EXPECT_LT(relative_difference(information, expected), 1e-7);
      EXPECT_LT(relative_difference(gram(whitening), information), 1e-12);
      EXPECT_TRUE(whitening.isLowerTriangular(0));
      EXPECT_GT(whitening.diagonal().minCoeff(), 0);
    };
    expect_weights(seen.camera, seen.T_cw);
    expect_weights(on_rig, T_cb.inverse() * seen.T_cw);
  });
}

TEST(MatchInformation, without_a_covariance_is_that_of_the_measurement) {
  MatchNoise noise;
  noise.sigma = 2;
  const double p_w[3] = {1, 2, 5};
  double omega[4];
  ASSERT_TRUE(match_information(PinholeCamera(400, 400, 320, 240), RigidTransform::identity(), p_w, noise, omega));
  const double expected[4] = {0.25, 0, 0, 0.25};
  for (int e = 0; e < 4; ++e) EXPECT_EQ(omega[e], expected[e]);
}

TEST(MatchInformation, takes_the_upper_triangle_of_the_covariance) {
  TracedRandom random;
  Seen seen;
  fill(random, seen);
  seen.covariance = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
  seen.noise.covariance = seen.covariance.data();
  double expected[9], actual[9];
  const RigidTransform T_cw = RigidTransform(seen.T_cw.matrix());
  ASSERT_TRUE(match_information(seen.camera, T_cw, seen.p_w.data(), seen.noise, expected));
  seen.covariance(1, 0) = seen.covariance(2, 0) = seen.covariance(2, 1) = nan;
  ASSERT_TRUE(match_information(seen.camera, T_cw, seen.p_w.data(), seen.noise, actual));
  EXPECT_EQ(matrix_of(actual, seen.rows()), matrix_of(expected, seen.rows()));
}

// A match that has both weights, until something of it is changed.
struct Case {
  Camera camera{458, 457, 367, 248, 50};
  RigidTransform T_cw = RigidTransform::identity();
  double p_w[3] = {0.5, 0.2, 5};
  MatchNoise noise;
  double covariance[9] = {0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
};

void expect(bool is_there, const char* what, const std::function<void(Case&)>& change) {
  SCOPED_TRACE(what);
  Case c;
  c.noise.depth_cue = DepthCue::stereo;
  c.noise.covariance = c.covariance;
  change(c);
  for (const bool is_whitening : {false, true}) {
    double entries[9];
    std::fill_n(entries, 9, -7.0);
    const bool was_written = is_whitening ? match_whitening(c.camera, c.T_cw, c.p_w, c.noise, entries)
                                          : match_information(c.camera, c.T_cw, c.p_w, c.noise, entries);
    EXPECT_EQ(was_written, is_there);
    for (const double entry : entries) EXPECT_TRUE(is_there ? std::isfinite(entry) : entry == -7.0);
  }
}

TEST(MatchInformation, does_not_exist_where_the_point_or_a_number_is_unusable) {
  expect(true, "as it should be", [](Case&) {});
  expect(false, "behind the camera", [](Case& c) { c.p_w[2] = -5; });
  expect(false, "in its plane", [](Case& c) { c.p_w[2] = 0; });
  expect(false, "no point", [](Case& c) { c.p_w[0] = nan; });
  expect(false, "a point at infinity", [](Case& c) { c.p_w[2] = infinity; });
  expect(false, "no pose", [](Case& c) { c.T_cw = nullptr; });
  const RigidTransform twice = (2 * Eigen::Matrix4d::Identity()).eval();
  expect(false, "no rotation", [&](Case& c) { c.T_cw = twice; });
  expect(false, "a camera at no rotation on its body", [&](Case& c) { c.camera.T_cb = twice; });
  for (const double sigma : {0.0, -1.0, nan, infinity, 1e-200}) {
    expect(false, "sigma", [&](Case& c) { c.noise.sigma = sigma; });
    expect(false, "depth_sigma", [&](Case& c) {
      c.noise.depth_cue = DepthCue::depth;
      c.noise.depth_sigma = sigma;
    });
  }
  expect(false, "no covariance", [](Case& c) { c.covariance[2] = nan; });
  expect(false, "not positive definite", [](Case& c) { c.covariance[0] = -1; });
  expect(false, "no digits left", [](Case& c) { c.covariance[8] = 1e30; });
  for (const double sigma : {-1.0, nan}) {
    expect(false, "map_sigma", [&](Case& c) {
      c.noise.covariance = nullptr;
      c.noise.map_sigma = sigma;
    });
  }
  expect(false, "stereo without bf", [](Case& c) { c.camera.pinhole.bf = 0; });
  expect(false, "stereo with a fisheye",
         [](Case& c) { c.camera = Camera::kannala_brandt(c.camera.pinhole, 0, 0, 0, 0); });
  expect(false, "no camera", [](Case& c) { c.camera = Camera(); });
  expect(false, "an unknown model", [](Case& c) { c.camera.model = CameraModel(9); });
  expect(false, "an unknown third", [](Case& c) { c.noise.depth_cue = DepthCue(3); });
  static_assert(noexcept(match_information(Camera(), nullptr, nullptr, MatchNoise(), nullptr)), "it throws nothing");
}

// H_x^T Omega H_x, J by p_c as written down here.
Matrix6 weighted_information(const PinholeCamera& camera, const Isometry& T_cw, const Eigen::Vector3d& p_w,
                             DepthCue depth_cue, const Eigen::MatrixXd& omega) {
  const Eigen::Vector3d p = T_cw * p_w;
  const WideMatrix H = wide_product(jacobian_of(camera, p, depth_cue), pose_derivative(p.cast<long double>()));
  return wide_product(wide_product(H.transpose(), omega.cast<long double>()), H).cast<double>();
}

// Compares the information of all matches together, for each weighting that models noise.
void expect_information_of_blocks(const sim::Frame& frame, DepthCue depth_cue) {
  const sim::MatchArrays arrays(frame);
  const Matches matches = arrays.view();
  Isometry T_cw;
  T_cw.matrix() << Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(frame.T_cw_prior.data()), 0, 0, 0, 1;
  for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
    BlockOptions options;
    options.weighting = weighting;
    options.depth_cue = depth_cue;
    BlockStore blocks;
    ASSERT_EQ(build_blocks(frame, arrays, options, blocks).error, Error::none);
    Matrix6 expected = Matrix6::Zero(), actual = Matrix6::Zero();
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (!blocks.is_valid(i)) continue;
      expected += gram(stored_block(blocks, i));
      const MatchNoise noise = match_noise(matches, i, options);
      double omega[9];
      const Eigen::Vector3d p_w(frame.matches[i].point);
      ASSERT_TRUE(
          match_information(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()), p_w.data(), noise, omega))
          << i;
      actual += weighted_information(frame.camera, T_cw, p_w, noise.depth_cue,
                                     matrix_of(omega, residual_rows(noise.depth_cue)));
    }
    EXPECT_LT(relative_difference(actual, expected), 1e-6) << to_string(weighting);
  }
}

TEST(MatchInformation, weighs_the_jacobians_to_the_information_of_the_blocks) {
  for (const sim::Scene scene : sim::scenes) {
    for (const DepthCue depth_cue : {DepthCue::none, DepthCue::stereo}) {
      TracedRandom random;
      sim::Frame frame = make_scene(scene, 500, random.seed());
      if (depth_cue == DepthCue::stereo && !(frame.camera.bf > 0)) frame.camera.bf = 47.9;
      expect_information_of_blocks(frame, depth_cue);
    }
  }
}

TEST(RealFrames, weights_give_the_information_of_the_blocks) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  const std::vector<sim::Frame> frames = real_frames();
  for (std::size_t i = 0; i < frames.size(); i += 10) {
    SCOPED_TRACE(frames[i].name);
    expect_information_of_blocks(frames[i], DepthCue::none);
    if (frames[i].camera.bf > 0) expect_information_of_blocks(frames[i], DepthCue::stereo);
  }
}

TEST(Project, has_no_jacobian_that_is_not_finite) {
  const double p_c[3] = {0, 0, 1e-310};
  double uv[2], jacobian[6];
  EXPECT_FALSE(project(Camera{PinholeCamera{450, 460, 320, 240, 0}}, p_c, uv, jacobian));
}

}  // namespace
}  // namespace maxlogdet::test
