// SPDX-License-Identifier: MIT
#pragma once

#include "odometry.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace stereo_vo {

/// The last image with its matches: where each was before, and a green dot for an inlier, a red cross for a wrong one,
/// an orange circle for a selected one.
inline cv::Mat draw_matches(const cv::Mat& image, const std::vector<DrawnMatch>& matches) {
  const cv::Scalar green(80, 200, 80), red(40, 40, 230), orange(0, 150, 255);  // blue, green, red
  cv::Mat picture;
  cv::cvtColor(image, picture, cv::COLOR_GRAY2BGR);
  picture *= 0.6;
  for (const DrawnMatch& match : matches) {
    const bool is_wrong = match.fate == Fate::wrong;
    cv::line(picture, match.from, match.to, is_wrong ? red : green, 1, cv::LINE_AA);
    if (is_wrong) {
      cv::drawMarker(picture, match.to, red, cv::MARKER_TILTED_CROSS, 7, 1, cv::LINE_AA);
    } else {
      cv::circle(picture, match.to, 2, green, cv::FILLED, cv::LINE_AA);
    }
    if (match.fate == Fate::selected) cv::circle(picture, match.to, 5, orange, 2, cv::LINE_AA);
  }
  return picture;
}

/// The path from above, the first camera looking up, with the lengths of its sides in m. `poses`: camera to world.
inline cv::Mat draw_path(const std::vector<cv::Affine3d>& poses, int width, int height) {
  const cv::Scalar black(0, 0, 0), blue(200, 80, 0), red(40, 40, 230);
  constexpr int margin = 40;
  double left = 0, right = 0, back = 0, front = 0;  // the first camera is at 0
  for (const cv::Affine3d& T_wc : poses) {
    const cv::Vec3d camera = T_wc.translation();
    left = std::min(left, camera[0]);
    right = std::max(right, camera[0]);
    back = std::min(back, camera[2]);
    front = std::max(front, camera[2]);
  }
  const double across = std::max(right - left, 1e-6), along = std::max(front - back, 1e-6);  // m
  const double scale = std::min((width - 2 * margin) / across, (height - 2 * margin) / along);
  const auto at = [&](const cv::Affine3d& T_wc) {
    return cv::Point(cvRound(width / 2.0 + scale * (T_wc.translation()[0] - (left + right) / 2)),
                     cvRound(height / 2.0 - scale * (T_wc.translation()[2] - (back + front) / 2)));
  };
  cv::Mat picture(height, width, CV_8UC3, cv::Scalar::all(255));
  for (std::size_t i = 1; i < poses.size(); ++i) {
    cv::line(picture, at(poses[i - 1]), at(poses[i]), blue, 2, cv::LINE_AA);
  }
  cv::drawMarker(picture, at(poses.front()), black, cv::MARKER_CROSS, 13, 2);
  cv::circle(picture, at(poses.back()), 5, red, cv::FILLED, cv::LINE_AA);
  const cv::String size = cv::format("cross: start, dot: end; %.2f m across, %.2f m along", across, along);
  cv::putText(picture, size, cv::Point(10, height - 10), cv::FONT_HERSHEY_SIMPLEX, 0.45, black, 1, cv::LINE_AA);
  return picture;
}

}  // namespace stereo_vo
