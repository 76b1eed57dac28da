// SPDX-License-Identifier: MIT
#pragma once

#include "sim/se3.hpp"

#include <maxlogdet/jacobian.hpp>

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stereo_odometry {

/// A stereo pair, or what a depth camera gives: then there is `depth`, of the left image's pixels, and no right image.
struct StereoImages {
  cv::Mat left, right;  ///< 8-bit grey, rectified, of one size
  cv::Mat depth;        ///< CV_32F, m; 0: none
};

/// Where the value of each pixel of a rectified image comes from; empty: the recorded images are rectified.
struct RectifyingMap {
  cv::Mat x, y;  ///< px, float32
};

/// What the readers of the layouts make of a folder; everything but the images.
struct Recording {
  struct Pair {
    double time = 0;                           ///< s
    std::string left, right;                   ///< image files; of an RGB-D recording colour and depth
    std::optional<maxlogdet::sim::Pose> T_wc;  ///< true pose, where known
  };
  std::vector<Pair> pairs;          ///< at least 1
  maxlogdet::PinholeCamera camera;  ///< rectified left camera
  int width = 0;                    ///< px
  int height = 0;                   ///< px
  RectifyingMap left_map, right_map;
  double depth_units = 0;  ///< of the depth images, a metre; 0: there are none, but right images
};

/// A sequence of stereo pairs, or of pairs of colour and depth, read from disk one by one. Const functions may be
/// called from several threads.
class StereoDataset {
 public:
  StereoDataset(std::string name, Recording recording) : name_(std::move(name)), recording_(std::move(recording)) {}

  /// Pairs, at least 1. The functions of i below throw std::out_of_range from there on.
  std::size_t size() const { return recording_.pairs.size(); }

  /// For tables and plots: the folder's name, other characters than letters, digits, `_`, `-` and `.` replaced by `_`.
  const std::string& name() const { return name_; }

  /// Rectified left camera, bf > 0; the right one, which with RGB-D is a virtual one, has the same fx, fy, cx, cy.
  const maxlogdet::PinholeCamera& camera() const { return recording_.camera; }
  int width() const { return recording_.width; }    ///< px
  int height() const { return recording_.height; }  ///< px

  /// s, increasing.
  double time(std::size_t i) const { return recording_.pairs.at(i).time; }

  /// Reads a pair; the images are the caller's. Throws sim::InputError that names the file: missing, unreadable, or of
  /// another size than width() x height(), or depth that is not of 16 bit.
  StereoImages load(std::size_t i) const;

  /// True pose of the rectified left camera, camera to world, m, where it is known.
  const std::optional<maxlogdet::sim::Pose>& truth(std::size_t i) const { return recording_.pairs.at(i).T_wc; }

 private:
  std::string name_;
  Recording recording_;
};

/// Opens a folder of KITTI odometry (kitti.cpp), of EuRoC in the ASL layout (euroc.cpp) or of TUM RGB-D (tum.cpp);
/// which one it is, is seen from its subfolders. Reads all text files, but of the images only the first, and of depth
/// images as many as there are without depth. Throws sim::InputError.
std::unique_ptr<StereoDataset> open_dataset(const std::string& folder);

}  // namespace stereo_odometry
