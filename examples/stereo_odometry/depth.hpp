// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>

// Depth in place of a right image: the column at which a camera beside this one, of the same lens, would see a point.
namespace stereo_odometry {

/// Of the pixel that `at` rounds to, px; `depth`: CV_32F, m, 0 for none. -1 where it is not known, or beyond the
/// image's left edge. Where a neighbour has no depth, or one that differs by more than a twentieth, there is an edge,
/// and it cannot be told which side of it a keypoint is on: not known.
///
/// Structured light measures this disparity to some 0.07 px from 1 m on (0.0012 m + 0.0019 (Z / m - 0.4)^2 m, Nguyen,
/// Izadi & Lovell 2012), far better than the left column is known, of which the error is the right one's as well: a
/// match takes both columns to be equally exact.
double virtual_right(const cv::Mat& depth, const cv::Point2f& at, double bf);

}  // namespace stereo_odometry
