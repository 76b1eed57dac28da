// SPDX-License-Identifier: MIT
#include "tests/odometry/rendered_world.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace maxlogdet::test {

Texture::Texture(const std::string& name) : values_(size * size) {
  Random random(name, 0);
  for (double& value : values_) value = random.uniform(-1, 1);
}

double Texture::at(double x, double y, double pitch) const {
  return 128 + 120 * (0.7 * noise(x / pitch, y / pitch) + 0.3 * noise(2 * x / pitch + 17, 2 * y / pitch + 31));
}

cv::Mat Texture::image(int width, int height, double pitch, double dx, double dy) const {
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(at(x - dx, y - dy, pitch));
    }
  }
  return image;
}

double Texture::value(int x, int y) const {
  return values_[(static_cast<std::size_t>(y) % size) * size + static_cast<std::size_t>(x) % size];
}

double Texture::noise(double x, double y) const {
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const auto eased = [](double t) { return t * t * (3 - 2 * t); };
  const double a = eased(x - i), b = eased(y - j);
  return (1 - b) * ((1 - a) * value(i, j) + a * value(i + 1, j)) +
         b * ((1 - a) * value(i, j + 1) + a * value(i + 1, j + 1));
}

RenderedWorld::RenderedWorld() : texture_("rendered world") {
  Random random("panels", 0);
  for (int i = 0; i < 12; ++i) {
    const double z = random.uniform(3.5, 9);
    panels_.push_back({z, random.uniform(-0.7, 0.9) * z, random.uniform(-0.4, 0.4) * z, random.uniform(0.1, 0.2) * z,
                       random.uniform(0.1, 0.2) * z});
  }
  panels_.push_back({12, 0, 0, 1000, 1000});
  std::sort(panels_.begin(), panels_.end(), [](const Panel& a, const Panel& b) { return a.z < b.z; });
}

sim::Pose RenderedWorld::T_wc(std::size_t frame) {
  const auto t = static_cast<double>(frame);
  return sim::Pose(Eigen::Translation3d(0.06 * t + 0.02 * std::sin(t), 0.03 * std::sin(0.5 * t), 0.05 * t) *
                   Eigen::AngleAxisd(0.01 * t, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(0.01 * std::sin(0.4 * t), Eigen::Vector3d::UnitX()));
}

stereo_odometry::StereoImages RenderedWorld::images(const sim::Pose& T_wc) const {
  return {image(T_wc), image(T_wc * Eigen::Translation3d(camera().bf / camera().fx, 0, 0)), {}};
}

stereo_odometry::StereoImages RenderedWorld::depth_images(const sim::Pose& T_wc) const {
  cv::Mat depths(height, width, CV_32F);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) depths.at<float>(v, u) = static_cast<float>(depth(T_wc, u, v));
  }
  return {image(T_wc), {}, depths};
}

stereo_odometry::StereoImages RenderedWorld::blank(int grey) {
  return {cv::Mat(height, width, CV_8UC1, cv::Scalar(grey)), cv::Mat(height, width, CV_8UC1, cv::Scalar(grey)), {}};
}

// The panels are sorted by z, so the nearest one comes first as long as the camera is in front of all.
RenderedWorld::Sight RenderedWorld::look(const sim::Pose& T_wc, double u, double v) const {
  const PinholeCamera K = camera();
  const Eigen::Vector3d ray = T_wc.linear() * Eigen::Vector3d((u - K.cx) / K.fx, (v - K.cy) / K.fy, 1);
  for (const Panel& panel : panels_) {
    const double depth = (panel.z - T_wc.translation().z()) / ray.z();
    const Eigen::Vector3d p = T_wc.translation() + depth * ray;
    if (std::abs(p.x() - panel.x) > panel.half_width || std::abs(p.y() - panel.y) > panel.half_height) continue;
    const double pitch = 7 * panel.z / K.fx;  // 7 px in a view from the origin
    return {depth, texture_.at(p.x() + 50 * panel.z, p.y() + 50 * panel.z, pitch)};
  }
  return {0, 0};
}

cv::Mat RenderedWorld::image(const sim::Pose& T_wc) const {
  cv::Mat image(height, width, CV_8UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      image.at<unsigned char>(v, u) = cv::saturate_cast<unsigned char>(look(T_wc, u, v).brightness);
    }
  }
  return image;
}

}  // namespace maxlogdet::test
