// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/dataset.hpp"
#include "bench/world/se3.hpp"
#include "tests/support/support.hpp"

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace maxlogdet::test {

/// Smooth random brightness: random values on grids of spacing `pitch` and half of that, smoothly interpolated.
class Texture {
 public:
  explicit Texture(const std::string& name);

  /// Grey value at (x, y), 8 to 248; the unit of x, y and pitch is the caller's.
  double at(double x, double y, double pitch) const;

  /// An image whose pixel (x, y) shows the texture at (x - dx, y - dy), px.
  cv::Mat image(int width, int height, double pitch, double dx = 0, double dy = 0) const;

 private:
  static constexpr std::size_t size = 256;

  double value(int x, int y) const;
  double noise(double x, double y) const;

  std::vector<double> values_;
};

/// Textured panels in front of a textured wall, all parallel to the plane z = 0, in views of a moving rectified stereo
/// camera: images and depths are known exactly.
class RenderedWorld {
 public:
  static constexpr int width = 480;  ///< px
  static constexpr int height = 320;

  RenderedWorld();

  /// The baseline is 0.3 m.
  static PinholeCamera camera() { return {300, 300, 239.5, 159.5, 90}; }

  /// True pose of the left camera, which moves forward and to the side and turns, about 8 cm and 0.6 deg per frame.
  static sim::Pose T_wc(std::size_t frame);

  /// Depth at a pixel of the left camera, m.
  double depth(const sim::Pose& T_wc, double u, double v) const { return look(T_wc, u, v).depth; }

  stereo_odometry::StereoImages images(const sim::Pose& T_wc) const;

  /// The same view of a depth camera with the virtual baseline of depth_camera().
  stereo_odometry::StereoImages depth_images(const sim::Pose& T_wc) const;
  static PinholeCamera depth_camera() { return {300, 300, 239.5, 159.5, 40}; }

  static stereo_odometry::StereoImages blank(int grey = 0);

 private:
  struct Panel {
    double z, x, y, half_width, half_height;  // m
  };

  struct Sight {
    double depth, brightness;
  };

  Sight look(const sim::Pose& T_wc, double u, double v) const;
  cv::Mat image(const sim::Pose& T_wc) const;

  Texture texture_;
  std::vector<Panel> panels_;
};

}  // namespace maxlogdet::test
