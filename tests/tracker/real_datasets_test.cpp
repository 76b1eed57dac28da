// SPDX-License-Identifier: MIT
// Recorded data of each layout, if present.
#include "tests/tracker/dataset_folder.hpp"

#include <opencv2/core.hpp>

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

TEST_F(RealDatasets, euroc_is_read_whole) {
  const auto dataset = open_dataset(data_folder() + "/euroc_static");
  ASSERT_EQ(dataset->size(), 10U);
  const PinholeCamera& camera = dataset->camera();
  EXPECT_NEAR(camera.bf / camera.fx, 0.11, 0.001) << "m, in every calibration of these cameras";
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    EXPECT_FALSE(dataset->truth(i).has_value());
    EXPECT_EQ(dataset->load(i).right.size(), cv::Size(dataset->width(), dataset->height()));
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
