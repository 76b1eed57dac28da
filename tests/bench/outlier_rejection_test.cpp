// SPDX-License-Identifier: MIT
// The rejection of outliers, against ORB-SLAM2's own poses; camera_frame_test.cpp plants outliers.
#include "bench/world/outlier_rejection.hpp"

#include "bench/world/angles.hpp"
#include "bench/world/frame_reader.hpp"
#include "tests/bench/pose_oracle.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/recording.hpp"
#include "tests/support/support.hpp"

#include <array>
#include <string>

namespace maxlogdet::test {
namespace {

TEST(OutlierRejection, uses_whitenings_with_errors_of_the_map) {
  TracedRandom random;
  Frame frame = simulated_frame(random, FrameKind::stereo, 200);
  for (const std::uint32_t i : all_matches(frame)) {
    set_covariance(frame, i, random_covariance(random, 0.1, 1e-5));
    const Eigen::Vector3d draws(normal(random), normal(random), normal(random));
    const Eigen::VectorXd error = product(cholesky(covariance_of(frame, i)), draws);
    for (int axis = 0; axis < 3; ++axis) frame.matches[i].point[axis] += error(axis);
  }
  const Pose start = pose_of(frame);
  const auto whitenings = whitenings_of(frame, start, true);
  const auto by_pixels = reject_outliers(frame.camera, frame.matches, all_matches(frame), start, {});
  const auto by_both = reject_outliers(frame.camera, frame.matches, all_matches(frame), start, {}, whitenings);
  EXPECT_LT(by_pixels.inliers.size(), 120U);
  EXPECT_GT(by_both.inliers.size(), 180U) << "95 % are expected";
  const Pose& T_cw = by_both.estimate.T_cw;
  for (const std::uint32_t i : all_matches(frame)) {
    LinearizedMatch at;
    const Match& match = frame.matches[i];
    ASSERT_TRUE(linearize(frame.camera, T_cw, match, true, at));
    const double expected = (whitenings[i].matrix() * at.residual).squaredNorm();
    EXPECT_NEAR(chi2(frame.camera, T_cw, match, true, &whitenings[i]), expected, 1e-9 * expected);
    const bool is_inlier = std::binary_search(by_both.inliers.begin(), by_both.inliers.end(), i);
    EXPECT_EQ(is_inlier, expected <= (at.rows == 3 ? chi2_of_three : chi2_of_two));
    EXPECT_EQ(is_inlier, agrees(frame.camera, match, T_cw, {}, &whitenings[i]));
  }
}

TEST(OutlierRejection, a_round_that_fails_is_the_last) {
  TracedRandom random;
  const Frame frame = simulated_frame(random, FrameKind::stereo, 10);
  const sim::Rejection rejection = reject_outliers(frame.camera, frame.matches, {7, 2}, pose_of(frame), {});
  EXPECT_EQ(rejection.estimate.status, PoseStatus::too_few_matches);
  EXPECT_EQ(rejection.inliers, (Subset{2, 7}));
  EXPECT_EQ(sim::to_rows(rejection.estimate.T_cw), frame.T_cw_prior);
}

TEST(OutlierRejection, reproduces_orb_slam2) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  double metres = 0;
  double degrees = 0;
  std::size_t matches = 0;
  std::size_t differing = 0;
  for (const sim::Frame& frame : real_frames()) {
    SCOPED_TRACE(frame.name);
    const RecordedFrame tracked(data_folder() + "/orb_slam2_frames/" + frame.name + ".csv");
    ASSERT_EQ(tracked.rows.size(), frame.matches.size());
    std::array<double, 12> rows{};
    const std::vector<double> numbers = tracked.numbers("Tcw_post");
    ASSERT_EQ(numbers.size(), rows.size());
    std::copy(numbers.begin(), numbers.end(), rows.begin());
    const Pose tracked_pose = sim::pose_of(rows);
    Subset all(frame.matches.size());
    std::iota(all.begin(), all.end(), 0U);
    const sim::RejectionOptions options;
    const auto rejection = reject_outliers(frame.camera, frame.matches, all, sim::pose_of(frame.T_cw_prior), options);
    EXPECT_TRUE(rejection.estimate.is_usable());
    const Pose& T_cw = rejection.estimate.T_cw;
    metres = std::max(metres, (T_cw.inverse().translation() - tracked_pose.inverse().translation()).norm());
    degrees = std::max(degrees, sim::rotation_angle(T_cw.linear() * tracked_pose.linear().transpose()) * 180 / sim::pi);
    for (const std::uint32_t i : all) {
      ++matches;
      const bool is_inlier = std::binary_search(rejection.inliers.begin(), rejection.inliers.end(), i);
      if (is_inlier != (tracked.at(i, "outlier_post") == 1)) continue;
      ++differing;
      const Match& match = frame.matches[i];
      const double limit = match.is_stereo() ? options.chi2_stereo : options.chi2_monocular;
      EXPECT_NEAR(chi2(frame.camera, T_cw, match, true) / limit, 1, 0.01) << "match " << i;
    }
  }
  EXPECT_LT(metres, 0.5e-3);
  EXPECT_LT(degrees, 0.01);
  RecordProperty("millimetres", std::to_string(1e3 * metres));
  RecordProperty("degrees", std::to_string(degrees));
  RecordProperty("differing_outliers", std::to_string(differing) + " of " + std::to_string(matches));
}

}  // namespace
}  // namespace maxlogdet::test
