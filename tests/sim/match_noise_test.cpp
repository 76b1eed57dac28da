// SPDX-License-Identifier: MIT
// What residuals are whitened by, against dense matrices, the blocks of the library, and errors that are drawn.
#include "sim/match_noise.hpp"

#include "sim/outlier_rejection.hpp"
#include "sim/pose_optimizer.hpp"
#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random_geometry.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/match_information.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::Match;
using sim::Pose;
using sim::PoseEstimate;
using sim::PoseMethod;
using sim::PoseOptions;
using sim::PoseStatus;
using sim::Whitening;
using Subset = std::vector<std::uint32_t>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

Pose pose_of(const Frame& frame) { return sim::pose_of(frame.T_cw_prior); }

// Exact matches of several octaves, some of them monocular, seen from anywhere.
Frame random_frame(Random& random, std::size_t n) {
  Frame frame;
  frame.camera = {450, 460, 376, 240, 50};
  const Pose T_cw = random_pose(random, 10, 1.5);
  frame.T_cw_prior = sim::to_rows(T_cw);
  for (std::size_t i = 0; i < n; ++i) {
    const double Z = random.uniform(2, 20);
    const Eigen::Vector3d p(Z * random.uniform(-0.4, 0.7), Z * random.uniform(-0.5, 0.5), Z);
    const Eigen::Vector3d in_world = T_cw.inverse() * p;
    Match match;
    std::copy_n(in_world.data(), 3, match.point);
    match.u = frame.camera.fx * p.x() / Z + frame.camera.cx;
    match.v = frame.camera.fy * p.y() / Z + frame.camera.cy;
    if (random.chance(0.7)) match.u_right = match.u - frame.camera.bf / Z;
    match.inv_sigma2 = std::pow(1.2, -2 * random.integer(0, 7));
    frame.matches.push_back(match);
  }
  return frame;
}

void set_covariance(Frame& frame, std::size_t i, const Eigen::Matrix3d& covariance) {
  frame.map_covariances.resize(frame.matches.size());
  std::copy_n(covariance.data(), 9, frame.map_covariances[i].begin());
}

Eigen::Matrix3d covariance_of(const Frame& frame, std::size_t i) {
  return Eigen::Map<const Eigen::Matrix3d>(frame.map_covariances[i].data());
}

std::vector<Whitening> whitenings_of(const Frame& frame, const Pose& T_cw, bool stereo, double map_sigma = 0) {
  std::vector<Whitening> whitenings;
  const double* const covariances = frame.map_covariances.empty() ? nullptr : frame.map_covariances.front().data();
  whiten(frame.camera, T_cw, frame.matches, stereo, covariances, map_sigma, whitenings);
  return whitenings;
}

Subset all_of(const Frame& frame) {
  Subset all(frame.matches.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

PoseOptions precise(PoseMethod method = PoseMethod::gauss_newton) {
  PoseOptions options;
  options.method = method;
  options.max_iterations = 100;
  options.step_tolerance = 1e-12;
  return options;
}

Vector6 difference(const Pose& a, const Pose& b) { return sim::log_se3(a * b.inverse()); }

// Sigma, 2 or 3 rows, written anew.
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
      EXPECT_LT(relative_difference(used, inverse(cholesky(covariance))), 1e-13 * condition) << "there is but one";
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

TEST(MatchNoise, whitening_is_that_of_the_library) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(30); trial > 0; --trial) {
    const Frame frame = random_frame(random, 20);
    const Pose T_cw = random_pose(random, 0.2, 0.05) * pose_of(frame);
    for (const Match& match : frame.matches) {
      const bool stereo = random.chance(0.7);
      const Eigen::Matrix3d map_covariance = random_covariance(random, std::pow(10, random.uniform(-4, 0.5)));
      MatchNoise noise;
      noise.sigma = 1 / std::sqrt(match.inv_sigma2);
      noise.covariance = map_covariance.data();
      noise.third = stereo && match.is_stereo() ? ThirdMeasurement::stereo : ThirdMeasurement::none;
      const auto rows = static_cast<Eigen::Index>(residual_rows(noise.third));
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> expected(rows, rows);
      ASSERT_TRUE(match_whitening(frame.camera, RigidTransform(sim::to_rows(T_cw).data()), match.point, noise,
                                  expected.data()));
      const Eigen::MatrixXd W = whitening_of(frame.camera, T_cw, match, stereo, map_covariance).matrix();
      const Eigen::VectorXd spectrum = singular_values(expected);
      const double condition = spectrum(0) / spectrum(rows - 1);
      EXPECT_LT(relative_difference(W.topLeftCorner(rows, rows), expected), 1e-14 * condition * condition);
    }
  }
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
  const std::vector<Whitening> told = whitenings_of(frame, pose_of(frame), true, 7);
  ASSERT_EQ(alike.size(), told.size());
  for (std::size_t i = 0; i < told.size(); ++i) EXPECT_EQ(alike[i].matrix(), told[i].matrix());
}

// ---------------------------------------------------------------------------------------------------------------------

// Matches, and covariances of their points, of which nothing can be made: all are added to the frame.
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

// A match that is good itself, with a whitening that is not.
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

// ---------------------------------------------------------------------------------------------------------------------

TEST(MatchNoise, deviations_as_whitenings_give_what_no_whitenings_do) {
  for (const double huber : {0.0, 2.0}) {
    Random random(static_cast<std::uint64_t>(huber));
    SCOPED_TRACE(random.name());
    for (std::size_t trial = trials(20); trial > 0; --trial) {
      Frame frame = random_frame(random, 60);
      std::vector<Whitening> whitenings;
      for (Match& match : frame.matches) {
        const double sigma = 1 / std::sqrt(match.inv_sigma2);
        match.u += sigma * normal(random);
        match.v += sigma * normal(random);
        if (match.is_stereo()) match.u_right += sigma * normal(random);
        whitenings.push_back({1 / sigma, 0, 1 / sigma, 0, 0, 1 / sigma});
      }
      const Pose start = random_pose(random, 0.1, 0.02) * pose_of(frame);
      PoseOptions options = precise();
      options.huber_monocular = options.huber_stereo = huber;
      const PoseEstimate expected = optimize_pose(frame.camera, frame.matches, all_of(frame), start, options);
      const PoseEstimate estimate =
          optimize_pose(frame.camera, frame.matches, all_of(frame), start, options, whitenings);
      EXPECT_EQ(estimate.status, PoseStatus::converged);
      EXPECT_LT(difference(estimate.T_cw, expected.T_cw).norm(), 1e-10);
      EXPECT_NEAR(estimate.cost, expected.cost, 1e-12 * expected.cost);
      EXPECT_LT(relative_difference(estimate.information, expected.information), 1e-9);
      for (const std::uint32_t i : all_of(frame)) {
        const double told = chi2(frame.camera, start, frame.matches[i], true);
        EXPECT_NEAR(chi2(frame.camera, start, frame.matches[i], true, &whitenings[i]), told, 1e-12 * told);
      }
    }
  }
}

// What is selected for its information counts with as much in the estimate.
TEST(MatchNoise, information_of_the_estimate_is_that_of_the_librarys_blocks) {
  for (const bool has_covariances : {false, true}) {
    for (const bool stereo : {false, true}) {
      Random random(has_covariances ? 1 : 0);
      SCOPED_TRACE(random.name());
      for (std::size_t trial = trials(20); trial > 0; --trial) {
        Frame frame = random_frame(random, 60);
        for (std::size_t i = 0; has_covariances && i < frame.matches.size(); ++i) {
          set_covariance(frame, i, random_covariance(random, 0.1));
        }
        BlockOptions blocks;
        blocks.weighting = Weighting::measurement_and_map;
        blocks.third = stereo ? ThirdMeasurement::stereo : ThirdMeasurement::none;
        blocks.map_sigma = 0.07;
        BlockStore store;
        build_blocks(frame, blocks, store);
        Matrix6 expected = Matrix6::Zero();
        for (std::size_t i = 0; i < frame.matches.size(); ++i) expected += gram(stored_block(store, i));

        const Pose T_cw = pose_of(frame);
        PoseOptions options = precise();
        options.stereo = stereo;
        options.max_iterations = 0;
        const PoseEstimate estimate = optimize_pose(frame.camera, frame.matches, all_of(frame), T_cw, options,
                                                    whitenings_of(frame, T_cw, stereo, blocks.map_sigma));
        // Entries compare with the diagonal scaled to 1: metres and radians are not mixed.
        const Vector6 scale = expected.diagonal().array().rsqrt();
        const Matrix6 apart = scale.asDiagonal() * (estimate.information - expected) * scale.asDiagonal();
        EXPECT_LT(largest_entry(apart), 1e-6);
      }
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------------

// Of a point that a stereo camera has mapped from some metres away: the deviation grows with the square of the depth
// and is largest along its rays, which are not those of now.
Eigen::Matrix3d covariance_of_triangulation(Random& random, const Pose& T_cw, const Match& match) {
  const Eigen::Vector3d mapped_from = T_cw.inverse() * random_pose(random, 5, 0).translation();
  const Eigen::Vector3d ray = Eigen::Map<const Eigen::Vector3d>(match.point) - mapped_from;
  const double distance = ray.norm();
  const double across = 0.0003 * distance;
  const double along = 0.0005 * distance * distance * random.uniform(0.2, 2);
  const Eigen::Matrix3d of_ray = ray * ray.transpose() / (distance * distance);
  return across * across * (Eigen::Matrix3d::Identity() - of_ray) + along * along * of_ray;
}

// The mean of chi2 with 6 degrees of freedom is 6, and its variance 12.
TEST(MatchNoise, with_errors_of_the_map_as_they_are_estimates_are_better_and_consistent) {
  Random random;
  SCOPED_TRACE(random.name());
  PoseOptions options = precise(PoseMethod::levenberg_marquardt);
  options.step_tolerance = 1e-7;
  const std::size_t count = trials(2000);
  const auto n = static_cast<double>(count);
  double nees = 0, nees_unaware = 0, metres2 = 0, metres2_unaware = 0, rad2 = 0, rad2_unaware = 0;
  for (std::size_t trial = 0; trial < count; ++trial) {
    Frame frame = random_frame(random, 60);
    const Pose truth = pose_of(frame);
    for (std::size_t i = 0; i < frame.matches.size(); ++i) {
      Match& match = frame.matches[i];
      match.inv_sigma2 *= 16;  // a quarter of a pixel at octave 0: the map counts
      const double sigma = 1 / std::sqrt(match.inv_sigma2);
      match.u += sigma * normal(random);
      match.v += sigma * normal(random);
      if (match.is_stereo()) match.u_right += sigma * normal(random);
      set_covariance(frame, i, covariance_of_triangulation(random, truth, match));
      const Eigen::Vector3d draws(normal(random), normal(random), normal(random));
      const Eigen::VectorXd error = product(cholesky(covariance_of(frame, i)), draws);
      for (int axis = 0; axis < 3; ++axis) match.point[axis] += error(axis);
    }
    const Pose start = random_pose(random, 0.02, 0.005) * truth;
    const std::vector<Whitening> whitenings = whitenings_of(frame, start, true);
    const PoseEstimate aware = optimize_pose(frame.camera, frame.matches, all_of(frame), start, options, whitenings);
    const PoseEstimate unaware = optimize_pose(frame.camera, frame.matches, all_of(frame), start, options);
    ASSERT_EQ(aware.status, PoseStatus::converged);
    ASSERT_EQ(unaware.status, PoseStatus::converged);
    const Vector6 error = difference(aware.T_cw, truth), error_unaware = difference(unaware.T_cw, truth);
    nees += squared_deviation(error, aware.covariance()) / n;
    nees_unaware += squared_deviation(error_unaware, unaware.covariance()) / n;
    metres2 += error.head<3>().squaredNorm() / n;
    metres2_unaware += error_unaware.head<3>().squaredNorm() / n;
    rad2 += error.tail<3>().squaredNorm() / n;
    rad2_unaware += error_unaware.tail<3>().squaredNorm() / n;
  }
  EXPECT_NEAR(nees, 6, 5 * std::sqrt(12 / n) + 0.1);
  EXPECT_GT(nees_unaware, 30) << "it takes what the map adds for something else";
  EXPECT_LT(metres2, 0.8 * metres2_unaware);
  EXPECT_LT(rad2, 0.8 * rad2_unaware);
  RecordProperty("nees", std::to_string(nees));
  RecordProperty("nees_unaware", std::to_string(nees_unaware));
  RecordProperty("error_ratio_m", std::to_string(std::sqrt(metres2 / metres2_unaware)));
  RecordProperty("error_ratio_rad", std::to_string(std::sqrt(rad2 / rad2_unaware)));
}

}  // namespace
}  // namespace maxlogdet::test
