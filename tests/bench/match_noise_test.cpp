// SPDX-License-Identifier: MIT
// What the map gives to the whitening of residuals, and what cannot be whitened; camera_frame_test.cpp compares its
// matrices.
#include "bench/world/match_noise.hpp"

#include "bench/world/outlier_rejection.hpp"
#include "tests/bench/pose_oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/traced_random.hpp"

#include <vector>

namespace maxlogdet::test {
namespace {

TEST(MatchNoise, without_errors_of_the_map_residuals_are_divided_by_their_deviation) {
  TracedRandom random;
  const Frame frame = simulated_frame(random, FrameKind::stereo, 50);
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

// Matches that can be whitened, but for their covariances; camera_frame_test.cpp has those that cannot without one.
TEST(MatchNoise, what_cannot_be_whitened_is_left_out) {
  TracedRandom random;
  Frame frame = simulated_frame(random, FrameKind::stereo, 40);
  add_errors(random, frame, 0.5);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) set_covariance(frame, i, random_covariance(random, 0.1));
  const Pose T_cw = pose_of(frame);
  const Subset good = all_matches(frame);
  const Eigen::Matrix3d negative = -10 * Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& bad :
       {Eigen::Matrix3d::Constant(nan).eval(), Eigen::Matrix3d::Constant(infinity).eval(), negative}) {
    frame.matches.push_back(frame.matches[0]);
    set_covariance(frame, frame.matches.size() - 1, bad);
  }
  frame.matches.push_back(frame.matches[0]);
  frame.matches.back().inv_sigma2 = 1e-310;  // a variance beyond float64
  set_covariance(frame, frame.matches.size() - 1, covariance_of(frame, 0));
  const Subset all = all_matches(frame);
  for (const bool stereo : {false, true}) {
    const std::vector<Whitening> whitenings = whitenings_of(frame, T_cw, stereo);
    for (const std::uint32_t i : all) {
      EXPECT_EQ(whitenings[i].matrix().allFinite(), i < good.size()) << i;
      EXPECT_EQ(chi2(frame.camera, T_cw, frame.matches[i], stereo, &whitenings[i]) < infinity, i < good.size()) << i;
    }
    for (const PoseMethod method : pose_methods) {
      PoseOptions options = precise(method);
      options.stereo = stereo;
      expect_same(optimize_pose(frame.camera, frame.matches, all, T_cw, options, whitenings),
                  optimize_pose(frame.camera, frame.matches, good, T_cw, options, whitenings));
    }
    sim::RejectionOptions options;
    options.stereo = stereo;
    const auto expected = reject_outliers(frame.camera, frame.matches, good, T_cw, options, whitenings);
    const auto rejection = reject_outliers(frame.camera, frame.matches, all, T_cw, options, whitenings);
    EXPECT_EQ(rejection.inliers, expected.inliers);
    EXPECT_EQ(sim::to_rows(rejection.estimate.T_cw), sim::to_rows(expected.estimate.T_cw));
  }
}

}  // namespace
}  // namespace maxlogdet::test
