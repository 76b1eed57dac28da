// SPDX-License-Identifier: MIT
// Depth images in the tracker: virtual right columns, and frames that lack depth.
#include "bench/does_it_track/depth.hpp"
#include "bench/does_it_track/matcher.hpp"
#include "bench/does_it_track/tracker.hpp"
#include "tests/odometry/rendered_world.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

using stereo_odometry::FrameStatus;
using stereo_odometry::StereoFeatures;
using stereo_odometry::StereoImages;
using stereo_odometry::StereoTracker;
using stereo_odometry::virtual_right;

constexpr double bf = 40;

TEST(VirtualRight, is_bf_over_depth_to_the_left) {
  const cv::Mat depth(20, 200, CV_32F, cv::Scalar(2));
  EXPECT_NEAR(virtual_right(depth, {100.3F, 10.4F}, bf), 100.3 - 20, 1e-5);
  EXPECT_EQ(virtual_right(depth, {19.9F, 10}, bf), -1) << "beyond the image";
}

TEST(VirtualRight, is_not_known_at_edges_and_holes) {
  const cv::Mat wall(9, 200, CV_32F, cv::Scalar(2));
  const auto with_neighbour = [&](float z) {
    cv::Mat depth = wall.clone();
    depth.at<float>(5, 151) = z;
    return virtual_right(depth, {150, 4}, bf);
  };
  EXPECT_GT(with_neighbour(2.05F), 0) << "slanted";
  for (const float z : {0.F, 1.8F, 2.2F, -1.F, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(with_neighbour(z), -1) << z;
  }
  for (const cv::Point2f at : {cv::Point2f(0, 4), cv::Point2f(199, 4), cv::Point2f(150, 0), cv::Point2f(150, 8)}) {
    EXPECT_EQ(virtual_right(wall, at, bf), -1) << "unknown outside the image: " << at;
  }
  for (const float z : {0.F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(virtual_right(cv::Mat(9, 200, CV_32F, cv::Scalar(z)), {150, 4}, bf), -1) << z;
  }
}

class DepthTracking : public ::testing::Test {
 protected:
  DepthTracking() : extractor_(RenderedWorld::depth_camera(), 700) {}

  StereoFeatures extract(std::size_t frame) { return extractor_.extract(images(frame)); }
  StereoImages images(std::size_t frame) const { return world_.depth_images(RenderedWorld::T_wc(frame)); }

  static StereoTracker tracker() {
    return {RenderedWorld::depth_camera(),
            RenderedWorld::width,
            RenderedWorld::height,
            {},
            RenderedWorld::T_wc(0).inverse()};
  }

  static double error(const sim::Pose& T_cw, std::size_t frame) {
    return (T_cw * RenderedWorld::T_wc(frame)).translation().norm();
  }

  RenderedWorld world_;
  stereo_odometry::FeatureExtractor extractor_;
};

TEST_F(DepthTracking, keypoints_have_the_depth_of_their_pixel) {
  const StereoFeatures features = extract(0);
  std::size_t with_depth = 0;
  ASSERT_EQ(features.u_right.size(), features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (features.u_right[i] < 0) continue;
    ++with_depth;
    const cv::Point2f at = features.keypoints[i].pt;
    const double z = world_.depth(RenderedWorld::T_wc(0), cvRound(at.x), cvRound(at.y));
    EXPECT_NEAR(features.u_right[i], at.x - bf / z, 1e-4);
  }
  EXPECT_GT(with_depth, features.size() * 3 / 4);
}

TEST_F(DepthTracking, aligned_matches_have_the_depth_of_where_they_are) {
  stereo_odometry::LocalMap map(RenderedWorld::depth_camera(), {});
  map.add_keyframe(RenderedWorld::T_wc(0).inverse(), extract(0), {}, {});
  const StereoFeatures now = extract(1);
  stereo_odometry::Matcher matcher(RenderedWorld::depth_camera(), RenderedWorld::width, RenderedWorld::height);
  matcher.start(now);
  matcher.predict(map.points(), RenderedWorld::T_wc(1).inverse());
  matcher.match_all(map, 4);
  std::size_t stereo = 0;
  for (const sim::Match& match : matcher.matches()) {
    if (!match.is_stereo()) continue;
    ++stereo;
    const double z = world_.depth(RenderedWorld::T_wc(1), std::round(match.u), std::round(match.v));
    EXPECT_NEAR(match.u_right, match.u - bf / z, 1e-4) << "the depth at the aligned position";
  }
  EXPECT_GT(stereo, 200U);
}

TEST_F(DepthTracking, frames_without_depth_are_tracked_by_what_the_map_has) {
  StereoTracker tracked = tracker();
  for (std::size_t i = 0; i < 5; ++i) {
    StereoImages seen = images(i);
    if (i >= 2) seen.depth = cv::Mat::zeros(seen.depth.size(), CV_32F);
    const auto& result = tracked.track(extractor_.extract(seen));
    EXPECT_EQ(result.status, i == 0 ? FrameStatus::initialized : FrameStatus::tracked) << i;
    EXPECT_LT(error(result.T_cw, i), 0.03) << i;
  }
}

TEST_F(DepthTracking, begins_with_the_first_frame_that_has_depth) {
  StereoTracker tracked = tracker();
  StereoImages first = images(0);
  first.depth = cv::Mat(first.depth.size(), CV_32F, cv::Scalar(std::nan("")));
  EXPECT_EQ(tracked.track(extractor_.extract(first)).status, FrameStatus::predicted);
  EXPECT_EQ(tracked.track(extract(1)).status, FrameStatus::initialized);
  EXPECT_EQ(tracked.track(extract(2)).status, FrameStatus::tracked);
}

}  // namespace
}  // namespace maxlogdet::test
