// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/dataset.hpp"
#include "sim/se3.hpp"
#include "tests/support/support.hpp"

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace maxlogdet::test {

/// Smooth random brightness: random values on a grid of spacing `pitch`, and half of it, eased in between.
class Texture {
 public:
  explicit Texture(const std::string& name);

  /// Grey value at (x, y), 8 to 248, in units of which `pitch` is one.
  double at(double x, double y, double pitch) const;

  /// What an image has whose pixel (x, y) shows the texture at (x - dx, y - dy), px.
  cv::Mat image(int width, int height, double pitch, double dx = 0, double dy = 0) const;

 private:
  static constexpr std::size_t size = 256;

  double value(int x, int y) const;
  double noise(double x, double y) const;

  std::vector<double> values_;
};

/// Textured panels in front of a textured wall, all parallel to the plane z = 0, seen by a rectified stereo camera that
/// moves among them: images and depths are known exactly.
class RenderedWorld {
 public:
  static constexpr int width = 480;  ///< px
  static constexpr int height = 320;

  RenderedWorld();

  /// A baseline of 0.3 m.
  static PinholeCamera camera() { return {300, 300, 239.5, 159.5, 90}; }

  /// True pose of the left camera at a frame: forward, to the side and turning, at about 8 cm and 0.6 deg a frame.
  static sim::Pose T_wc(std::size_t frame);

  /// Depth of what the left camera sees at a pixel, m.
  double depth(const sim::Pose& T_wc, double u, double v) const { return look(T_wc, u, v).depth; }

  stereo_odometry::StereoImages images(const sim::Pose& T_wc) const;

  /// The same from a depth camera, whose virtual baseline is depth_camera()'s.
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
