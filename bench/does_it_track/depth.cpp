// SPDX-License-Identifier: MIT
#include "bench/does_it_track/depth.hpp"

namespace stereo_odometry {

double virtual_right(const cv::Mat& depth, const cv::Point2f& at, double bf) {
  constexpr double largest_step = 0.05;  // of the depth
  const cv::Point pixel(cvRound(at.x), cvRound(at.y));
  const cv::Rect inside(1, 1, depth.cols - 2, depth.rows - 2);
  if (!inside.contains(pixel)) return -1;
  double nearest = 0, farthest = 0;
  cv::minMaxLoc(depth({pixel.x - 1, pixel.y - 1, 3, 3}), &nearest, &farthest);
  const double z = depth.at<float>(pixel);
  if (!(nearest > 0) || !(farthest - nearest <= largest_step * z)) return -1;
  const double u = at.x - bf / z;
  return u >= 0 ? u : -1;
}

}  // namespace stereo_odometry
