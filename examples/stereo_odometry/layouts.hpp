// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/dataset.hpp"

#include <opencv2/core/types.hpp>
#include <string>

// What open_dataset() puts together. Everything here throws sim::InputError, which names the file.
namespace stereo_odometry {

/// `left_images` and `right_images` are the folders of rectified images (*.png), `left_matrix` the number of the
/// projection matrices that calib.txt may call P0: to P3: (left one even, right one odd).
struct KittiFolders {
  const char* left_images;
  const char* right_images;
  int left_matrix;
};

/// KITTI odometry: rectified images, calib.txt, and, if they are there, times.txt and poses.txt.
Recording read_kitti(const std::string& folder, const KittiFolders& names);

/// EuRoC, ASL layout: `mav0` holds cam0 and cam1, and perhaps state_groundtruth_estimate0; `folder`, perhaps
/// ground_truth.txt (TUM format), which is looked at if mav0 has no truth.
Recording read_euroc(const std::string& folder, const std::string& mav0);

/// TUM RGB-D: camera.txt; associations.txt, or rgb.txt and depth.txt; their images; and, if it is there,
/// groundtruth.txt.
Recording read_tum_rgbd(const std::string& folder);

/// An image as 8-bit grey, of the given size unless that is empty.
cv::Mat read_grey(const std::string& file, const cv::Size& size = {});

/// A depth image as it is recorded, CV_16U, of the given size.
cv::Mat read_depth(const std::string& file, const cv::Size& size);

/// Whether fx, fy and bf are finite and positive.
bool is_stereo(const maxlogdet::PinholeCamera& camera);

/// Whether all pixels come from the recorded image or not far beside it; a distortion without sense leads anywhere.
bool comes_from_image(const RectifyingMap& map, const cv::Size& size);

}  // namespace stereo_odometry
