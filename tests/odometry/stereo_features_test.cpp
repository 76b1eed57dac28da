// SPDX-License-Identifier: MIT
#include "bench/does_it_track/features.hpp"
#include "tests/odometry/rendered_world.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <opencv2/core/utility.hpp>
#include <opencv2/video/tracking.hpp>

namespace maxlogdet::test {
namespace {

using stereo_odometry::Alignment;
using stereo_odometry::FeatureExtractor;
using stereo_odometry::StereoFeatures;
using stereo_odometry::StereoImages;

std::vector<cv::Mat> pyramid_of(const cv::Mat& image) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, {13, 13}, 1);
  return pyramid;
}

// Aligns the points, starting from the same positions.
Alignment aligned(const std::vector<cv::Mat>& before, const std::vector<cv::Mat>& after,
                  const std::vector<cv::Point2f>& points) {
  Alignment alignment;
  alignment.from = alignment.start = points;
  alignment.run(before, after);
  return alignment;
}

std::vector<cv::Point2f> random_points(Random& random, int width, int height, int margin, std::size_t count) {
  std::vector<cv::Point2f> points;
  while (points.size() < count) {
    points.emplace_back(static_cast<float>(random.uniform(margin, width - margin)),
                        static_cast<float>(random.uniform(margin, height - margin)));
  }
  return points;
}

TEST(Align, finds_patches_that_moved_by_less_than_a_few_pixels) {
  TracedRandom random;
  const Texture texture(random.name());
  const std::vector<cv::Mat> before = pyramid_of(texture.image(200, 150, 8));
  for (int i = 0; i < 10; ++i) {
    const double dx = random.uniform(-2, 2), dy = random.uniform(-2, 2);
    const std::vector<cv::Mat> after = pyramid_of(texture.image(200, 150, 8, dx, dy));
    const std::vector<cv::Point2f> from = random_points(random, 200, 150, 20, 40);
    const Alignment found = aligned(before, after, from);
    ASSERT_EQ(found.is_aligned.size(), from.size());
    for (std::size_t p = 0; p < from.size(); ++p) {
      ASSERT_TRUE(found.is_aligned[p] != 0) << from[p] << " moved by " << dx << ", " << dy;
      EXPECT_NEAR(static_cast<double>(found.to[p].x - from[p].x), dx, 0.1) << from[p];
      EXPECT_NEAR(static_cast<double>(found.to[p].y - from[p].y), dy, 0.1) << from[p];
    }
  }
}

TEST(Align, refuses_what_is_far_away) {
  TracedRandom random;
  const Texture texture(random.name());
  const std::vector<cv::Point2f> from = random_points(random, 200, 150, 30, 40);
  const auto found = [&](double dx) {
    const Alignment alignment =
        aligned(pyramid_of(texture.image(200, 150, 32)), pyramid_of(texture.image(200, 150, 32, dx)), from);
    return 40 - std::count(alignment.is_aligned.begin(), alignment.is_aligned.end(), 0);
  };
  EXPECT_EQ(found(3.5), 40);
  EXPECT_EQ(found(4.5), 0) << "even where optical flow converges";
}

TEST(Align, refuses_where_there_is_no_texture) {
  Random random;
  const std::vector<cv::Mat> grey = pyramid_of(cv::Mat(150, 200, CV_8UC1, cv::Scalar(128)));
  const std::vector<cv::Point2f> from = random_points(random, 200, 150, 0, 20);
  EXPECT_EQ(aligned(grey, grey, from).is_aligned, std::vector<unsigned char>(20, 0));
  EXPECT_TRUE(aligned(grey, grey, {}).is_aligned.empty());
}

TEST(FeatureExtractor, stereo_matches_are_where_the_scene_has_them) {
  const RenderedWorld world;
  FeatureExtractor extractor(RenderedWorld::camera(), 600);
  for (const std::size_t frame : {0U, 7U}) {
    const sim::Pose T_wc = RenderedWorld::T_wc(frame);
    const StereoFeatures features = extractor.extract(world.images(T_wc));
    ASSERT_EQ(features.u_right.size(), features.size());
    std::size_t matched = 0, right = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const cv::Point2f& pixel = features.keypoints[i].pt;
      if (features.u_right[i] < 0) continue;
      ++matched;
      const double depth = world.depth(T_wc, static_cast<double>(pixel.x), static_cast<double>(pixel.y));
      const double expected = static_cast<double>(pixel.x) - RenderedWorld::camera().bf / depth;
      if (std::abs(features.u_right[i] - expected) < 0.3) ++right;
    }
    EXPECT_GT(matched, features.size() / 3);
    EXPECT_GT(static_cast<double>(right), 0.85 * static_cast<double>(matched)) << "except at the edges of panels";
  }
}

TEST(FeatureExtractor, spreads_at_most_count_keypoints_over_all_texture) {
  const RenderedWorld world;
  StereoImages images = world.images(RenderedWorld::T_wc(0));
  images.left.colRange(240, 480).setTo(128);  // one half has no texture
  for (const int count : {30, 100, 300}) {
    FeatureExtractor extractor(RenderedWorld::camera(), count);
    const StereoFeatures features = extractor.extract(images);
    EXPECT_EQ(features.size(), static_cast<std::size_t>(count)) << "there are more corners than that";
    EXPECT_EQ(features.descriptors.rows, count);
    EXPECT_EQ(features.descriptors.cols, 32);
    cv::Mat in_cell = cv::Mat::zeros(8, 12, CV_32S);
    for (const cv::KeyPoint& k : features.keypoints) {
      EXPECT_LT(k.pt.x, 245);
      ++in_cell.at<int>(static_cast<int>(k.pt.y) / 40, static_cast<int>(k.pt.x) / 40);
    }
    if (count == 30) {
      double fullest = 0;
      cv::minMaxLoc(in_cell, nullptr, &fullest);
      EXPECT_LE(fullest, 2) << "the best corner of each cell comes before any second one";
      EXPECT_GE(cv::countNonZero(in_cell), 25);
    }
    if (count == 300) {
      // Cells that are entirely where ORB finds keypoints, at least 31 px from the border.
      EXPECT_EQ(cv::countNonZero(in_cell(cv::Rect(1, 1, 5, 6))), 30) << in_cell;
    }
  }
}

TEST(FeatureExtractor, finds_nothing_on_blank_images) {
  FeatureExtractor extractor(RenderedWorld::camera(), 400);
  for (const int grey : {0, 128, 255}) {
    const StereoFeatures features = extractor.extract(RenderedWorld::blank(grey));
    EXPECT_EQ(features.size() + features.u_right.size(), 0U);
  }
  const RenderedWorld world;
  StereoImages images = world.images(RenderedWorld::T_wc(0));
  images.right.setTo(0);  // only the right camera is blind
  const StereoFeatures features = extractor.extract(images);
  EXPECT_EQ(features.size(), 400U);
  EXPECT_EQ(features.u_right, std::vector<double>(400, -1));
}

TEST(FeatureExtractor, takes_images_smaller_than_its_rim) {
  const Texture texture("small");
  FeatureExtractor extractor(RenderedWorld::camera(), 400);
  for (const int size : {4, 31, 63}) {
    const StereoImages images = {texture.image(size, size, 4), texture.image(size, size, 4), {}};
    EXPECT_LE(extractor.extract(images).size(), 400U) << size;
  }
}

}  // namespace
}  // namespace maxlogdet::test
