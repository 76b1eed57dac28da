// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/dataset.hpp"
#include "sim/se3.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace maxlogdet::test {

/// Smooth random brightness: random values on a grid of spacing `pitch`, and half of it, eased in between.
class Texture {
 public:
  explicit Texture(const std::string& name) : values_(size * size) {
    Random random(name, 0);
    for (double& value : values_) value = random.uniform(-1, 1);
  }

  /// Grey value at (x, y), 8 to 248, in units of which `pitch` is one.
  double at(double x, double y, double pitch) const {
    return 128 + 120 * (0.7 * noise(x / pitch, y / pitch) + 0.3 * noise(2 * x / pitch + 17, 2 * y / pitch + 31));
  }

  /// What an image has whose pixel (x, y) shows the texture at (x - dx, y - dy), px.
  cv::Mat image(int width, int height, double pitch, double dx = 0, double dy = 0) const {
    cv::Mat image(height, width, CV_8UC1);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(at(x - dx, y - dy, pitch));
      }
    }
    return image;
  }

 private:
  static constexpr std::size_t size = 256;

  double value(int x, int y) const {
    return values_[(static_cast<std::size_t>(y) % size) * size + static_cast<std::size_t>(x) % size];
  }

  double noise(double x, double y) const {
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    const auto eased = [](double t) { return t * t * (3 - 2 * t); };
    const double a = eased(x - i), b = eased(y - j);
    return (1 - b) * ((1 - a) * value(i, j) + a * value(i + 1, j)) +
           b * ((1 - a) * value(i, j + 1) + a * value(i + 1, j + 1));
  }

  std::vector<double> values_;
};

/// Textured panels in front of a textured wall, all parallel to the plane z = 0, seen by a rectified stereo camera that
/// moves among them: images and depths are known exactly.
class RenderedWorld {
 public:
  static constexpr int width = 480;  ///< px
  static constexpr int height = 320;

  RenderedWorld() : texture_("rendered world") {
    Random random("panels", 0);
    for (int i = 0; i < 12; ++i) {
      const double z = random.uniform(3.5, 9);
      panels_.push_back({z, random.uniform(-0.7, 0.9) * z, random.uniform(-0.4, 0.4) * z, random.uniform(0.1, 0.2) * z,
                         random.uniform(0.1, 0.2) * z});
    }
    panels_.push_back({12, 0, 0, 1000, 1000});
    std::sort(panels_.begin(), panels_.end(), [](const Panel& a, const Panel& b) { return a.z < b.z; });
  }

  /// A baseline of 0.3 m.
  static PinholeCamera camera() { return {300, 300, 239.5, 159.5, 90}; }

  /// True pose of the left camera at a frame: forward, to the side and turning, at about 8 cm and 0.6 deg a frame.
  static sim::Pose T_wc(std::size_t frame) {
    const auto t = static_cast<double>(frame);
    return sim::Pose(Eigen::Translation3d(0.06 * t + 0.02 * std::sin(t), 0.03 * std::sin(0.5 * t), 0.05 * t) *
                     Eigen::AngleAxisd(0.01 * t, Eigen::Vector3d::UnitY()) *
                     Eigen::AngleAxisd(0.01 * std::sin(0.4 * t), Eigen::Vector3d::UnitX()));
  }

  /// Depth of what the left camera sees at a pixel, m.
  double depth(const sim::Pose& T_wc, double u, double v) const { return look(T_wc, u, v).depth; }

  stereo_odometry::StereoImages images(const sim::Pose& T_wc) const {
    return {image(T_wc), image(T_wc * Eigen::Translation3d(camera().bf / camera().fx, 0, 0))};
  }

  static stereo_odometry::StereoImages blank(int grey = 0) {
    return {cv::Mat(height, width, CV_8UC1, cv::Scalar(grey)), cv::Mat(height, width, CV_8UC1, cv::Scalar(grey))};
  }

 private:
  struct Panel {
    double z, x, y, half_width, half_height;  // m
  };

  struct Sight {
    double depth, brightness;
  };

  // Nearest first is right as long as the camera is before all of them.
  Sight look(const sim::Pose& T_wc, double u, double v) const {
    const PinholeCamera K = camera();
    const Eigen::Vector3d ray = T_wc.linear() * Eigen::Vector3d((u - K.cx) / K.fx, (v - K.cy) / K.fy, 1);
    for (const Panel& panel : panels_) {
      const double depth = (panel.z - T_wc.translation().z()) / ray.z();
      const Eigen::Vector3d p = T_wc.translation() + depth * ray;
      if (std::abs(p.x() - panel.x) > panel.half_width || std::abs(p.y() - panel.y) > panel.half_height) continue;
      const double pitch = 7 * panel.z / K.fx;  // 7 px, seen from the origin
      return {depth, texture_.at(p.x() + 50 * panel.z, p.y() + 50 * panel.z, pitch)};
    }
    return {0, 0};
  }

  cv::Mat image(const sim::Pose& T_wc) const {
    cv::Mat image(height, width, CV_8UC1);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        image.at<unsigned char>(v, u) = cv::saturate_cast<unsigned char>(look(T_wc, u, v).brightness);
      }
    }
    return image;
  }

  Texture texture_;
  std::vector<Panel> panels_;
};

}  // namespace maxlogdet::test
