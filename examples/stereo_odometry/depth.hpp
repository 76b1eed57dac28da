// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>

// Depth in place of a right image: the column at which a camera beside this one, of the same lens, would see a point.
namespace stereo_odometry {

struct VirtualRight {
  double u = -1;               ///< px; -1: not known, or beyond the image's left edge
  double disparity_sigma = 0;  ///< deviation of what was subtracted from the left column, px
};

/// Of the pixel that `at` rounds to; `depth`: CV_32F, m, 0 for none. Where a neighbour has no depth, or one that
/// differs by more than a twentieth, there is an edge, and it cannot be told which side of it a keypoint is on: not
/// known.
VirtualRight virtual_right(const cv::Mat& depth, const cv::Point2f& at, double bf);

}  // namespace stereo_odometry
