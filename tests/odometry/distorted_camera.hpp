// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

// An oracle of cameras with distortion, and images of blobs as such cameras see points.
namespace maxlogdet::test {

/// A pinhole with radial-tangential distortion.
struct DistortedCamera {
  double fx, fy, cx, cy, k1, k2, p1, p2, k3 = 0;

  /// px, of a point in the camera's frame.
  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
            fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
  }
};

/// Calls body(x, y, squared distance from z) for the pixels of an image within some 7 px of z.
template <class Body>
void for_pixels_near(const cv::Mat& image, const Eigen::Vector2d& z, const Body& body) {
  const int u = static_cast<int>(z.x()), v = static_cast<int>(z.y());
  for (int y = std::max(0, v - 7); y <= std::min(image.rows - 1, v + 8); ++y) {
    for (int x = std::max(0, u - 7); x <= std::min(image.cols - 1, u + 8); ++x) {
      body(x, y, (Eigen::Vector2d(x, y) - z).squaredNorm());
    }
  }
}

/// Adds a blob around z to an image of CV_64F.
inline void draw_blob(cv::Mat& image, const Eigen::Vector2d& z) {
  for_pixels_near(image, z, [&image](int x, int y, double squared) {
    image.at<double>(y, x) += 220 * std::exp(-squared / (2 * 1.3 * 1.3));
  });
}

/// The centre of the blob around z, px, in a window of +-6 px; nothing if the window leaves the image.
inline std::optional<Eigen::Vector2d> blob_near(const cv::Mat& image, const Eigen::Vector2d& z) {
  constexpr int half = 6;
  const int u = static_cast<int>(std::lround(z.x()));
  const int v = static_cast<int>(std::lround(z.y()));
  if (u < half || v < half || u + half >= image.cols || v + half >= image.rows) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int y = v - half; y <= v + half; ++y) {
    for (int x = u - half; x <= u + half; ++x) sum += image.at<unsigned char>(y, x) * Eigen::Vector3d(x, y, 1);
  }
  return sum.hnormalized();
}

}  // namespace maxlogdet::test
