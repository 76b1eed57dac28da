// SPDX-License-Identifier: MIT
// Images and depth of an RGB-D camera whose lens distorts.
#include "tests/odometry/distorted_camera.hpp"
#include "tests/odometry/rgbd_dataset_folder.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace maxlogdet::test {
namespace {

class DistortedRgbd : public RgbdFolder, public ::testing::WithParamInterface<DistortedCamera> {
 protected:
  static constexpr int columns = 320;
  static constexpr int rows = 240;

  DistortedRgbd() {
    const DistortedCamera& c = GetParam();
    write("camera.txt", {numbers({c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3}), "320 240 5000"});
    write("associations.txt", Lines{"1.0 rgb/0.png 1.0 depth/0.png"});
  }

  // Points on a grid in the image, at random depths.
  std::vector<Eigen::Vector3d> points() const {
    Random random("points", 0);
    std::vector<Eigen::Vector3d> result;
    for (int v = -100; v <= 100; v += 25) {
      for (int u = -140; u <= 140; u += 28) {
        result.emplace_back(random.uniform(0.6, 6) * Eigen::Vector3d(u / GetParam().fx, v / GetParam().fy, 1));
      }
    }
    return result;
  }

  // Draws a blob and the depth around each point.
  void draw() const {
    cv::Mat image(rows, columns, CV_64F, cv::Scalar(0)), depths(rows, columns, CV_16UC1, cv::Scalar(0));
    for (const Eigen::Vector3d& point : points()) {
      const Eigen::Vector2d z = GetParam().project(point);
      draw_blob(image, z);
      for_pixels_near(depths, z, [&](int x, int y, double squared) {
        if (squared < 9) depths.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(std::lround(5000 * point.z()));
      });
    }
    image.convertTo(image, CV_8U);
    write(colour(0), image);
    write(depth(0), depths);
  }
};

TEST_P(DistortedRgbd, points_are_where_a_pinhole_has_them_and_as_far) {
  draw();
  const auto dataset = open_dataset(folder_);
  const PinholeCamera& camera = dataset->camera();
  const StereoImages images = dataset->load(0);
  std::size_t seen = 0;
  for (const Eigen::Vector3d& p : points()) {
    const Eigen::Vector2d z(camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy);
    const cv::Point pixel(cvRound(z.x()), cvRound(z.y()));
    if (!cv::Rect(6, 6, columns - 12, rows - 12).contains(pixel)) continue;
    ++seen;
    const cv::Moments m = cv::moments(images.left({pixel.x - 6, pixel.y - 6, 13, 13}));
    const Eigen::Vector2d middle(pixel.x - 6 + m.m10 / m.m00, pixel.y - 6 + m.m01 / m.m00);
    EXPECT_LT((middle - z).norm(), 0.15) << z.transpose();
    EXPECT_NEAR(static_cast<double>(images.depth.at<float>(pixel)), p.z(), 1e-4 + 1e-6) << z.transpose();
  }
  EXPECT_GT(seen, 60U);
}

TEST_P(DistortedRgbd, pixels_come_from_the_image_or_less_than_a_pixel_beside_it) {
  draw();
  const auto dataset = open_dataset(folder_);
  const PinholeCamera& camera = dataset->camera();
  double farthest = 0;  // px, beyond the centres of the outermost pixels
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < columns; ++u) {
      const Eigen::Vector2d z = GetParam().project({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1});
      farthest = std::max({farthest, -z.x(), -z.y(), z.x() - (columns - 1), z.y() - (rows - 1)});
    }
  }
  EXPECT_LT(farthest, 1);
}

TEST_P(DistortedRgbd, has_no_black_border_and_depth_never_between_two_sides) {
  cv::Mat depths(rows, columns, CV_16UC1, cv::Scalar(5000));
  depths.colRange(columns / 2, columns) = cv::Scalar(20000);
  write(colour(0), cv::Mat(rows, columns, CV_8UC1, cv::Scalar(200)));
  write(depth(0), depths);
  const StereoImages images = open_dataset(folder_)->load(0);
  EXPECT_TRUE(same(images.left, cv::Mat(rows, columns, CV_8UC1, cv::Scalar(200)))) << "no black border";
  EXPECT_EQ(cv::countNonZero(images.depth == 1) + cv::countNonZero(images.depth == 4), rows * columns);
}

INSTANTIATE_TEST_SUITE_P(Cameras, DistortedRgbd,
                         ::testing::Values(DistortedCamera{258.7, 258.2, 159.3, 127.7, 0.262383, -0.953104, -0.005358,
                                                           0.002628, 1.163314},
                                           DistortedCamera{229.3, 228.6, 160, 118, -0.2834, 0.074, 0.0002, 2e-5, 0},
                                           DistortedCamera{250, 251, 159.5, 119.5, 0.1, 0, 0, 0, 0}));

}  // namespace
}  // namespace maxlogdet::test
