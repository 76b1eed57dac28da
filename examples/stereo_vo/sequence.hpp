// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace stereo_vo {

/// A file that cannot be used: one line with its name and what was expected.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What is known of the cameras.
struct Calibration {
  cv::Matx33d K = cv::Matx33d::eye();  ///< of the left image, or of the one with depths, px
  std::vector<double> distortion;      ///< k1, k2, p1, p2, k3, as OpenCV has them; empty: images are rectified
  double bf = 0;                       ///< stereo: baseline times fx, px m
  double cx_right = 0;                 ///< stereo: cx of the right image, px
};

/// A grey image, and either the right image or the depths.
struct Frame {
  std::string time;  ///< TUM: of the image, as the file has it, s
  cv::Mat left;      ///< CV_8U
  cv::Mat right;     ///< stereo: CV_8U, else empty
  cv::Mat depth;     ///< RGB-D: CV_32F, m, 0 where there is none, else empty
};

/// Recorded images in one of two layouts.
///
/// KITTI: image_0/ and image_1/, or image_l/ and image_r/, hold rectified pairs of equal names; calib.txt has their
/// projection matrices, 3 x 4 row-major, in its first two lines, which may begin with a name such as `P0:`.
///
/// TUM RGB-D: associations.txt has lines `time image time depth`; camera.txt has the lines `fx fy cx cy k1 k2 p1 p2 k3`
/// and `width height depth_units_per_metre`. In both, lines that start with # are comments.
class Sequence {
 public:
  /// Reads everything but the images. Throws InputError.
  explicit Sequence(const std::string& folder);

  bool is_rgbd() const { return is_rgbd_; }
  const Calibration& calibration() const { return calibration_; }
  std::size_t size() const { return files_.size(); }
  /// Reads the images of frame i, which all have the same size. Throws InputError.
  Frame read(std::size_t i);

 private:
  struct Files {
    std::string time, image, other;  // other: the right image, or the depths
  };
  void read_kitti(const std::string& folder);
  void read_tum(const std::string& folder);

  bool is_rgbd_ = false;
  double depth_units_ = 0;  // a metre
  Calibration calibration_;
  cv::Size image_size_;  // of the first image that was read
  std::vector<Files> files_;
};

}  // namespace stereo_vo
