// SPDX-License-Identifier: MIT
// Recorded data of each layout, if present.
#include "tests/tracker/dataset_folder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace maxlogdet::test {
namespace {

class RealDatasets : public ::testing::Test {
 protected:
  void SetUp() override {
    if (data_folder().empty() || !fs::is_directory(data_folder() + "/kitti_clip_1") ||
        !fs::is_directory(data_folder() + "/euroc_static")) {
      GTEST_SKIP() << no_real_frames;
    }
  }
};

TEST_F(RealDatasets, kitti_is_read_whole) {
  const auto dataset = open_dataset(data_folder() + "/kitti_clip_1");
  EXPECT_EQ(dataset->name(), "kitti_clip_1");
  ASSERT_EQ(dataset->size(), 51U);
  EXPECT_EQ(dataset->width(), 1226);
  EXPECT_EQ(dataset->height(), 370);
  EXPECT_NEAR(dataset->camera().bf, 379.8145, 1e-9);
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    EXPECT_EQ(dataset->load(i).left.size(), cv::Size(1226, 370));
    EXPECT_TRUE(dataset->truth(i).has_value());
  }
  EXPECT_GT(dataset->truth(50)->translation().z(), 50) << "a straight road";
}

// Distances of matched corners from each other's row, |dv|, px, ascending.
std::vector<double> row_offsets(const StereoImages& images) {
  std::vector<cv::KeyPoint> left, right;
  cv::Mat left_descriptors, right_descriptors;
  const auto orb = cv::ORB::create(1000);
  orb->detectAndCompute(images.left, cv::noArray(), left, left_descriptors);
  orb->detectAndCompute(images.right, cv::noArray(), right, right_descriptors);
  // The scene is repetitive: only keypoints within 5 rows and 150 columns may match, enough to reveal wrong rows.
  cv::Mat may_match(static_cast<int>(left.size()), static_cast<int>(right.size()), CV_8U);
  for (int j = 0; j < may_match.rows; ++j) {
    for (int k = 0; k < may_match.cols; ++k) {
      const cv::Point2f d = left[static_cast<std::size_t>(j)].pt - right[static_cast<std::size_t>(k)].pt;
      may_match.at<unsigned char>(j, k) = std::abs(d.y) <= 5 && d.x >= 0 && d.x <= 150 ? 1 : 0;
    }
  }
  std::vector<cv::DMatch> matches;
  cv::BFMatcher(cv::NORM_HAMMING).match(left_descriptors, right_descriptors, matches, may_match);
  std::vector<cv::Point2f> left_points, right_points;
  for (const cv::DMatch& match : matches) {
    const cv::KeyPoint& from = left[static_cast<std::size_t>(match.queryIdx)];
    const cv::KeyPoint& to = right[static_cast<std::size_t>(match.trainIdx)];
    if (match.distance >= 30 || from.octave != 0 || to.octave != 0) continue;
    left_points.push_back(from.pt);
    right_points.push_back(to.pt);
  }
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01);
  cv::cornerSubPix(images.left, left_points, {5, 5}, {-1, -1}, criteria);  // ORB's corners are whole pixels
  cv::cornerSubPix(images.right, right_points, {5, 5}, {-1, -1}, criteria);
  std::vector<double> offsets;  // |dv|, px
  for (std::size_t j = 0; j < left_points.size(); ++j) {
    offsets.push_back(static_cast<double>(std::abs(left_points[j].y - right_points[j].y)));
  }
  std::sort(offsets.begin(), offsets.end());
  return offsets;
}

TEST_F(RealDatasets, rectified_rows_of_euroc_agree) {
  const auto dataset = open_dataset(data_folder() + "/euroc_static");
  ASSERT_EQ(dataset->size(), 10U);
  const PinholeCamera& camera = dataset->camera();
  EXPECT_NEAR(camera.bf / camera.fx, 0.11, 0.001) << "m, in every calibration of these cameras";
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_FALSE(dataset->truth(i).has_value());
    const std::vector<double> offsets = row_offsets(dataset->load(i));
    ASSERT_GT(offsets.size(), 50U);
    EXPECT_LT(offsets[offsets.size() / 2], 0.5) << offsets.size() << " matches";
  }
}

TEST(RealRgbd, tum_is_read_whole) {
  const std::string folder = data_folder() + "/tum_fr1_rpy_a";
  if (data_folder().empty() || !fs::is_directory(folder)) GTEST_SKIP() << no_real_frames;
  const auto dataset = open_dataset(folder);
  EXPECT_EQ(dataset->name(), "tum_fr1_rpy_a");
  ASSERT_EQ(dataset->size(), 120U);
  EXPECT_EQ(dataset->width(), 640);
  EXPECT_EQ(dataset->height(), 480);
  EXPECT_GT(dataset->camera().fx, 517) << "enlarged from a crop of the recorded images";
  EXPECT_LT(dataset->camera().fx, 560);
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    const StereoImages images = dataset->load(i);
    EXPECT_GT(cv::countNonZero(images.depth), 640 * 480 / 3) << i;
    double farthest = 0;
    cv::minMaxLoc(images.depth, nullptr, &farthest);
    EXPECT_LT(farthest, 13.2) << "the maximum of 16 bit, m";
    EXPECT_TRUE(dataset->truth(i).has_value()) << i;
  }
}

}  // namespace
}  // namespace maxlogdet::test
