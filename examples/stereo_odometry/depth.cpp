// SPDX-License-Identifier: MIT
#include "examples/stereo_odometry/depth.hpp"

namespace stereo_odometry {
namespace {

constexpr double largest_step = 0.05;  // of the depth

// Of structured light, m (Nguyen, Izadi & Lovell 2012, seen from the front): as a disparity it is nearly constant.
double deviation_of(double depth) { return 0.0012 + 0.0019 * (depth - 0.4) * (depth - 0.4); }

}  // namespace

VirtualRight virtual_right(const cv::Mat& depth, const cv::Point2f& at, double bf) {
  const cv::Point pixel(cvRound(at.x), cvRound(at.y));
  const cv::Rect inside(1, 1, depth.cols - 2, depth.rows - 2);
  if (!inside.contains(pixel)) return {};
  double least = 0, most = 0;
  cv::minMaxLoc(depth({pixel.x - 1, pixel.y - 1, 3, 3}), &least, &most);
  const double z = depth.at<float>(pixel);
  if (!(least > 0) || !(most - least <= largest_step * z)) return {};
  const double u = at.x - bf / z;
  if (!(u >= 0)) return {};
  return {u, bf / (z * z) * deviation_of(z)};
}

}  // namespace stereo_odometry
