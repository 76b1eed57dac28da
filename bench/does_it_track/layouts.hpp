// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/dataset.hpp"
#include "bench/world/text_file.hpp"

#include <opencv2/core/types.hpp>
#include <string>
#include <string_view>

// The readers that open_dataset() chooses from. All functions throw sim::InputError, which names the file.
namespace stereo_odometry {

/// The folders of rectified images (*.png), and the number of the left camera's projection matrix where calib.txt names
/// them P0: to P3: (the left one is even, the right one odd).
struct KittiFolders {
  const char* left_images;
  const char* right_images;
  int left_matrix;
};

/// KITTI odometry: rectified images, calib.txt, and optionally times.txt and poses.txt.
Recording read_kitti(const std::string& folder, const KittiFolders& names);

/// EuRoC, ASL layout: `mav0` has cam0, cam1, and optionally state_groundtruth_estimate0; without the latter, `folder`
/// may have ground_truth.txt (TUM format).
Recording read_euroc(const std::string& folder, const std::string& mav0);

/// TUM RGB-D: camera.txt; associations.txt, or rgb.txt and depth.txt; their images; and optionally groundtruth.txt.
Recording read_tum_rgbd(const std::string& folder);

/// An image as 8-bit grey, of the given size unless that is empty.
cv::Mat read_grey(const std::string& file, const cv::Size& size = {});

/// A depth image as recorded, CV_16U, of the given size.
cv::Mat read_depth(const std::string& file, const cv::Size& size);

/// Whether cv::remap takes images with this side: a whole number of pixels up to its limit.
bool is_image_side(double side);
constexpr const char* expected_image_sides = "a width and height from 1 to 32766 px";

/// Fails if the name of a file could not be shown in a message.
void refuse_control_characters(const maxlogdet::sim::TextFile& file, std::string_view name);

/// s, between poses of the ground truth that are interpolated: 10 Hz with rounded stamps.
constexpr double max_truth_gap = 0.1 + 1e-4;

/// Whether fx, fy and bf are finite and positive.
bool is_stereo(const maxlogdet::PinholeCamera& camera);

/// Whether all pixels come from the recorded image or from near its border; with a nonsensical distortion they do not.
bool comes_from_image(const RectifyingMap& map, const cv::Size& size);

}  // namespace stereo_odometry
