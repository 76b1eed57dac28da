// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"

#include <maxlogdet/jacobian.hpp>

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stereo_odometry {

/// A stereo pair; or the image of a depth camera with `depth` at its pixels, and no right image.
struct StereoImages {
  cv::Mat left, right;  ///< 8-bit grey, rectified, of one size
  cv::Mat depth;        ///< CV_32F, m; 0: none
};

/// The source of each pixel of a rectified image; empty: the recorded images are rectified.
struct RectifyingMap {
  cv::Mat x, y;  ///< px, float32
};

/// The contents of a folder without the images, as the readers of the layouts return them.
struct Recording {
  struct Pair {
    double time = 0;                           ///< s
    std::string left, right;                   ///< image files; in RGB-D recordings colour and depth
    std::optional<maxlogdet::sim::Pose> T_wc;  ///< true pose, if known
  };
  std::vector<Pair> pairs;          ///< at least 1
  maxlogdet::PinholeCamera camera;  ///< rectified left camera
  int width = 0;                    ///< px
  int height = 0;                   ///< px
  RectifyingMap left_map, right_map;
  double depth_units = 0;  ///< of the depth images, per metre; 0: stereo
};

/// A sequence of stereo pairs, or of pairs of colour and depth, read from disk one by one. Several threads may call
/// const functions.
class StereoDataset {
 public:
  StereoDataset(std::string name, Recording recording) : name_(std::move(name)), recording_(std::move(recording)) {}

  /// The number of pairs, at least 1. The functions of i below throw std::out_of_range from size() on.
  std::size_t size() const { return recording_.pairs.size(); }

  /// For tables and plots: the folder's name; all but letters, digits, `_`, `-` and `.` are replaced by `_`.
  const std::string& name() const { return name_; }

  /// Rectified left camera, bf > 0. The right camera, virtual in RGB-D recordings, has the same fx, fy, cx, cy.
  const maxlogdet::PinholeCamera& camera() const { return recording_.camera; }
  int width() const { return recording_.width; }    ///< px
  int height() const { return recording_.height; }  ///< px

  /// s, increasing.
  double time(std::size_t i) const { return recording_.pairs.at(i).time; }

  /// Reads a pair. Throws sim::InputError, which names the file, if an image is missing or unreadable, if its size is
  /// not width() x height(), or if depth does not have 16 bit.
  StereoImages load(std::size_t i) const;

  /// True pose of the rectified left camera, camera to world, m, if known.
  const std::optional<maxlogdet::sim::Pose>& truth(std::size_t i) const { return recording_.pairs.at(i).T_wc; }

 private:
  std::string name_;
  Recording recording_;
};

/// Opens a folder of KITTI odometry (kitti.cpp), of EuRoC in the ASL layout (euroc.cpp) or of TUM RGB-D (tum.cpp),
/// which it recognises by the subfolders. Reads all text files, the first image, and depth images until one has any
/// depth. Throws sim::InputError.
std::unique_ptr<StereoDataset> open_dataset(const std::string& folder);

}  // namespace stereo_odometry
