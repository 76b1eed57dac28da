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

/// An image as 8-bit grey, of the given size unless that is empty.
cv::Mat read_grey(const std::string& file, const cv::Size& size = {});

}  // namespace stereo_odometry
