// SPDX-License-Identifier: MIT
// Poses from whitened residuals, against random errors.
#include "bench/world/pose_optimizer.hpp"

#include "tests/bench/noisy_frame.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

// The covariance of a point that a stereo camera mapped from another pose: the deviation grows with the square of the
// depth and is largest along that camera's ray.
Eigen::Matrix3d covariance_of_triangulation(Random& random, const Pose& T_cw, const Match& match) {
  const Eigen::Vector3d mapped_from = T_cw.inverse() * random_pose(random, 5, 0).translation();
  const Eigen::Vector3d ray = Eigen::Map<const Eigen::Vector3d>(match.point) - mapped_from;
  const double distance = ray.norm();
  const double across = 0.0003 * distance;
  const double along = 0.0005 * distance * distance * random.uniform(0.2, 2);
  const Eigen::Matrix3d of_ray = ray * ray.transpose() / (distance * distance);
  return across * across * (Eigen::Matrix3d::Identity() - of_ray) + along * along * of_ray;
}

// Adds errors to pixels and map points by their covariances.
void add_errors(Random& random, const Pose& truth, Frame& frame) {
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    Match& match = frame.matches[i];
    match.inv_sigma2 *= 16;  // a quarter of a pixel at octave 0: errors of the map matter
    const double sigma = 1 / std::sqrt(match.inv_sigma2);
    match.u += sigma * normal(random);
    match.v += sigma * normal(random);
    if (match.is_stereo()) match.u_right += sigma * normal(random);
    set_covariance(frame, i, covariance_of_triangulation(random, truth, match));
    const Eigen::Vector3d draws(normal(random), normal(random), normal(random));
    const Eigen::VectorXd error = product(cholesky(covariance_of(frame, i)), draws);
    for (int axis = 0; axis < 3; ++axis) match.point[axis] += error(axis);
  }
}

// The mean of chi2 with 6 degrees of freedom is 6, and its variance 12.
TEST(MatchNoise, with_true_covariances_of_the_map_estimates_are_better_and_consistent) {
  TracedRandom random;
  PoseOptions options = precise(PoseMethod::levenberg_marquardt);
  options.step_tolerance = 1e-7;
  const std::size_t count = trials(2000);
  const auto n = static_cast<double>(count);
  double nees = 0, nees_unaware = 0, metres2 = 0, metres2_unaware = 0, rad2 = 0, rad2_unaware = 0;
  for (std::size_t trial = 0; trial < count; ++trial) {
    Frame frame = simulated_frame(random, FrameKind::stereo, 60);
    const Pose truth = pose_of(frame);
    add_errors(random, truth, frame);
    const Pose start = random_pose(random, 0.02, 0.005) * truth;
    const std::vector<Whitening> whitenings = whitenings_of(frame, start, true);
    const PoseEstimate aware =
        optimize_pose(frame.camera, frame.matches, all_matches(frame), start, options, whitenings);
    const PoseEstimate unaware = optimize_pose(frame.camera, frame.matches, all_matches(frame), start, options);
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
  EXPECT_GT(nees_unaware, 30) << "its covariance lacks the errors of the map";
  EXPECT_LT(metres2, 0.8 * metres2_unaware);
  EXPECT_LT(rad2, 0.8 * rad2_unaware);
  RecordProperty("nees", std::to_string(nees));
  RecordProperty("nees_unaware", std::to_string(nees_unaware));
  RecordProperty("error_ratio_m", std::to_string(std::sqrt(metres2 / metres2_unaware)));
  RecordProperty("error_ratio_rad", std::to_string(std::sqrt(rad2 / rad2_unaware)));
}

}  // namespace
}  // namespace maxlogdet::test
