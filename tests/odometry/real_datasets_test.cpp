// SPDX-License-Identifier: MIT
// Recorded data of each layout, if present.
#include "tests/odometry/dataset_folder.hpp"

#include <memory>
#include <opencv2/core.hpp>

namespace maxlogdet::test {
namespace {

// Opens a recording and loads all of it; null where it is not there.
std::unique_ptr<stereo_odometry::StereoDataset> read_whole(const std::string& name, std::size_t size, bool has_truth) {
  const std::string folder = data_folder() + "/" + name;
  if (data_folder().empty() || !fs::is_directory(folder)) return nullptr;
  auto dataset = open_dataset(folder);
  EXPECT_EQ(dataset->name(), name);
  EXPECT_EQ(dataset->size(), size);
  const cv::Size expected(dataset->width(), dataset->height());
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    EXPECT_EQ(dataset->truth(i).has_value(), has_truth) << i;
    const StereoImages images = dataset->load(i);
    EXPECT_EQ(images.left.size(), expected);
    EXPECT_EQ((images.depth.empty() ? images.right : images.depth).size(), expected);
    if (images.depth.empty()) continue;
    EXPECT_GT(cv::countNonZero(images.depth), expected.area() / 3) << i;
    double farthest = 0;
    cv::minMaxLoc(images.depth, nullptr, &farthest);
    EXPECT_LT(farthest, 13.2) << "the maximum of 16 bit, m";
  }
  return dataset;
}

TEST(RealDatasets, are_read_whole) {
  const auto kitti = read_whole("kitti_clip_1", 51, true), euroc = read_whole("euroc_static", 10, false),
             tum = read_whole("tum_fr1_rpy_a", 120, true);
  if (!kitti && !euroc && !tum) GTEST_SKIP() << no_real_frames;
  if (kitti) {
    EXPECT_EQ(cv::Size(kitti->width(), kitti->height()), cv::Size(1226, 370));
    EXPECT_NEAR(kitti->camera().bf, 379.8145, 1e-9);
    EXPECT_GT(kitti->truth(50)->translation().z(), 50) << "a straight road";
  }
  if (euroc) {
    EXPECT_NEAR(euroc->camera().bf / euroc->camera().fx, 0.11, 0.001) << "m, in every calibration of these cameras";
  }
  if (tum) {
    EXPECT_EQ(cv::Size(tum->width(), tum->height()), cv::Size(640, 480));
    EXPECT_GT(tum->camera().fx, 517) << "enlarged from a crop of the recorded images";
    EXPECT_LT(tum->camera().fx, 560);
  }
}

}  // namespace
}  // namespace maxlogdet::test
