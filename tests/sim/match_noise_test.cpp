// SPDX-License-Identifier: MIT
// The whitening of residuals, against dense matrices.
#include "sim/match_noise.hpp"

#include "sim/outlier_rejection.hpp"
#include "tests/sim/noisy_frame.hpp"
#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// Sigma, 2 or 3 rows, by dense matrices.
Eigen::MatrixXd dense_covariance(const Frame& frame, const Pose& T_cw, std::size_t i, bool stereo,
                                 const Eigen::Matrix3d& map_covariance) {
  const Match& match = frame.matches[i];
  const PinholeCamera& camera = frame.camera;
  const Eigen::Vector3d p = T_cw * Eigen::Map<const Eigen::Vector3d>(match.point);
  const double X = p.x(), Y = p.y(), Z = p.z();
  Eigen::MatrixXd of_camera_frame(3, 3);
  of_camera_frame << camera.fx / Z, 0, -camera.fx * X / (Z * Z),  //
      0, camera.fy / Z, -camera.fy * Y / (Z * Z),                 //
      camera.fx / Z, 0, (camera.bf - camera.fx * X) / (Z * Z);
  const Eigen::MatrixXd J = product(of_camera_frame.topRows(stereo && match.is_stereo() ? 3 : 2), T_cw.linear());
  Eigen::MatrixXd covariance = product(J, product(map_covariance, J.transpose()));
  covariance.diagonal().array() += 1 / match.inv_sigma2;
  return covariance;
}

TEST(MatchNoise, whitening_makes_the_covariance_of_residuals_the_identity) {
  Random random;
  SCOPED_TRACE(random.name());
  std::size_t of_three_rows = 0;
  for (std::size_t trial = trials(30); trial > 0; --trial) {
    const Frame frame = random_frame(random, 20);
    const Pose T_cw = random_pose(random, 0.2, 0.05) * pose_of(frame);
    for (std::size_t i = 0; i < frame.matches.size(); ++i) {
      const bool stereo = random.chance(0.7);
      const Eigen::Matrix3d map_covariance = random_covariance(random, std::pow(10, random.uniform(-4, 0.5)));
      const Whitening whitening = whitening_of(frame.camera, T_cw, frame.matches[i], stereo, map_covariance);
      const Eigen::Matrix3d W = whitening.matrix();
      const Eigen::MatrixXd covariance = dense_covariance(frame, T_cw, i, stereo, map_covariance);
      const Eigen::Index rows = covariance.rows();
      if (rows == 3) ++of_three_rows;

      const Eigen::MatrixXd used = W.topLeftCorner(rows, rows);
      const Eigen::MatrixXd unit = product(used, product(covariance, used.transpose()));
      const Eigen::VectorXd spectrum = singular_values(covariance);
      const double condition = spectrum(0) / spectrum(rows - 1);
      EXPECT_LT(largest_difference(unit, Eigen::MatrixXd::Identity(rows, rows)), 1e-13 * condition);
      EXPECT_LT(relative_difference(used, inverse(cholesky(covariance))), 1e-13 * condition) << "it is unique";
      EXPECT_TRUE(W.isLowerTriangular(0));
      EXPECT_GT(used.diagonal().minCoeff(), 0);
      if (rows == 2) {
        EXPECT_EQ(W.row(2).norm(), 0);
      }

      const Eigen::Vector3d e(random.uniform(-5, 5), random.uniform(-5, 5), rows == 3 ? random.uniform(-5, 5) : 0);
      Eigen::Vector3d whitened = e;
      whitening.apply(whitened(0), whitened(1), whitened(2));
      EXPECT_LT((whitened - W * e).norm(), 1e-14 * (1 + whitened.norm()) * std::sqrt(condition));
    }
  }
  EXPECT_GT(of_three_rows, 0U);
}

TEST(MatchNoise, without_errors_of_the_map_residuals_are_divided_by_their_deviation) {
  Random random;
  SCOPED_TRACE(random.name());
  const Frame frame = random_frame(random, 50);
  for (const bool stereo : {false, true}) {
    const std::vector<Whitening> whitenings = whitenings_of(frame, pose_of(frame), stereo);
    ASSERT_EQ(whitenings.size(), frame.matches.size());
    for (std::size_t i = 0; i < whitenings.size(); ++i) {
      const Match& match = frame.matches[i];
      Eigen::Vector3d diagonal = Eigen::Vector3d::Constant(std::sqrt(match.inv_sigma2));
      if (!stereo || !match.is_stereo()) diagonal.z() = 0;
      EXPECT_LT(largest_difference(whitenings[i].matrix(), Eigen::Matrix3d(diagonal.asDiagonal())), 1e-15);
    }
  }
}

TEST(MatchNoise, a_map_without_covariances_has_one_deviation_for_all) {
  Random random;
  SCOPED_TRACE(random.name());
  Frame frame = random_frame(random, 50);
  const std::vector<Whitening> alike = whitenings_of(frame, pose_of(frame), true, 0.05);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    set_covariance(frame, i, 0.05 * 0.05 * Eigen::Matrix3d::Identity());
  }
  const std::vector<Whitening> given = whitenings_of(frame, pose_of(frame), true, 7);
  ASSERT_EQ(alike.size(), given.size());
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_EQ(alike[i].matrix(), given[i].matrix());
}

// Adds matches to the frame that cannot be whitened.
Subset add_spoilt(Frame& frame) {
  Subset spoilt;
  const Pose T_wc = pose_of(frame).inverse();
  const Eigen::Matrix3d good = covariance_of(frame, 0);
  const auto add = [&](const Match& match, const Eigen::Matrix3d& covariance) {
    spoilt.push_back(static_cast<std::uint32_t>(frame.matches.size()));
    frame.matches.push_back(match);
    set_covariance(frame, frame.matches.size() - 1, covariance);
  };
  for (const double Z : {0.0, -1.0}) {
    const Eigen::Vector3d p = T_wc * Eigen::Vector3d(0.5, 0.5, Z);
    Match match = frame.matches[0];
    std::copy_n(p.data(), 3, match.point);
    add(match, good);
  }
  for (const double bad : {0.0, 1e-310, -1.0, nan, infinity}) {
    Match match = frame.matches[0];
    match.inv_sigma2 = bad;
    add(match, good);
  }
  for (const double bad : {nan, infinity}) {
    Match match = frame.matches[0];
    match.point[1] = bad;
    add(match, good);
    add(frame.matches[0], Eigen::Matrix3d::Constant(bad));
  }
  add(frame.matches[0], -10 * Eigen::Matrix3d::Identity());
  return spoilt;
}

TEST(MatchNoise, what_cannot_be_whitened_is_left_out) {
  Random random;
  SCOPED_TRACE(random.name());
  Frame frame = random_frame(random, 40);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    set_covariance(frame, i, random_covariance(random, 0.1));
    frame.matches[i].u += 0.5 * normal(random);
  }
  const Pose T_cw = pose_of(frame);
  const Subset good = all_of(frame);
  const Subset spoilt = add_spoilt(frame);
  const Subset all = all_of(frame);
  for (const bool stereo : {false, true}) {
    const std::vector<Whitening> whitenings = whitenings_of(frame, T_cw, stereo);
    for (const std::uint32_t i : good) EXPECT_TRUE(whitenings[i].matrix().allFinite());
    for (const std::uint32_t i : spoilt) {
      EXPECT_FALSE(whitenings[i].matrix().allFinite()) << i;
      EXPECT_EQ(chi2(frame.camera, T_cw, frame.matches[i], stereo, &whitenings[i]), infinity) << i;
    }
    for (const PoseMethod method : {PoseMethod::gauss_newton, PoseMethod::levenberg_marquardt}) {
      PoseOptions options = precise(method);
      options.stereo = stereo;
      const PoseEstimate expected = optimize_pose(frame.camera, frame.matches, good, T_cw, options, whitenings);
      const PoseEstimate estimate = optimize_pose(frame.camera, frame.matches, all, T_cw, options, whitenings);
      EXPECT_EQ(estimate.status, PoseStatus::converged);
      EXPECT_EQ(sim::to_rows(estimate.T_cw), sim::to_rows(expected.T_cw));
      EXPECT_EQ(estimate.information, expected.information);
      EXPECT_EQ(estimate.cost, expected.cost);
    }
    sim::RejectionOptions options;
    options.stereo = stereo;
    const auto expected = reject_outliers(frame.camera, frame.matches, good, T_cw, options, whitenings);
    const auto rejection = reject_outliers(frame.camera, frame.matches, all, T_cw, options, whitenings);
    EXPECT_EQ(rejection.inliers, expected.inliers);
    EXPECT_EQ(sim::to_rows(rejection.estimate.T_cw), sim::to_rows(expected.estimate.T_cw));
  }
}

// A good match with a bad whitening.
TEST(MatchNoise, a_whitening_that_is_not_finite_leaves_its_match_out) {
  Random random;
  SCOPED_TRACE(random.name());
  Frame frame = random_frame(random, 40);
  for (Match& match : frame.matches) {
    match.u_right = match.u - frame.camera.bf / in_camera(frame, match)[2];  // all have three rows
    match.v += 0.5 * normal(random);
  }
  const Pose T_cw = pose_of(frame);
  const std::vector<Whitening> whitenings = whitenings_of(frame, T_cw, true, 0.05);
  const Subset all = all_of(frame);
  const Subset others(all.begin() + 1, all.end());
  for (const PoseMethod method : {PoseMethod::gauss_newton, PoseMethod::levenberg_marquardt}) {
    const PoseOptions options = precise(method);
    const PoseEstimate expected = optimize_pose(frame.camera, frame.matches, others, T_cw, options, whitenings);
    for (double Whitening::*const entry :
         {&Whitening::w00, &Whitening::w10, &Whitening::w11, &Whitening::w20, &Whitening::w21, &Whitening::w22}) {
      for (const double bad : {nan, infinity, -infinity}) {
        std::vector<Whitening> spoilt = whitenings;
        spoilt[0].*entry = bad;
        EXPECT_EQ(chi2(frame.camera, T_cw, frame.matches[0], true, spoilt.data()), infinity);
        const PoseEstimate estimate = optimize_pose(frame.camera, frame.matches, all, T_cw, options, spoilt);
        EXPECT_EQ(estimate.status, expected.status);
        EXPECT_EQ(sim::to_rows(estimate.T_cw), sim::to_rows(expected.T_cw));
        EXPECT_EQ(estimate.cost, expected.cost);
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
