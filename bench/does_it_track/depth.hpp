// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>

// Depth instead of a right image: the column at which a second camera with the same lens would see a point.
namespace stereo_odometry {

/// The column for the pixel that `at` rounds to, px; `depth`: CV_32F, m, 0 for none. -1 if it is unknown or beyond the
/// image's left edge. It is unknown at edges, where a neighbour has no depth or one that differs by more than a
/// twentieth, because a keypoint may be on either side.
///
/// Structured light measures this disparity to some 0.07 px from 1 m on (0.0012 m + 0.0019 (Z / m - 0.4)^2 m, Nguyen,
/// Izadi & Lovell 2012). The error of the left column, which both columns share, is far larger: a match takes both to
/// be equally exact.
double virtual_right(const cv::Mat& depth, const cv::Point2f& at, double bf);

}  // namespace stereo_odometry
