// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/dataset.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <array>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

namespace stereo_odometry {

/// The ORB pyramid: level l is smaller by scale_factor^l, and its keypoints are less exact by the same factor.
constexpr double scale_factor = 1.2;
constexpr int pyramid_levels = 8;
double scale_of(int octave);

using Descriptor = std::array<unsigned char, 32>;  ///< ORB

/// Standard deviation of a keyframe's observation in the map, px. Matches of the frame have sim::MotionNoise instead.
constexpr double aligned_sigma = 0.5;

/// Keypoints of the left image with their columns in the right image, or in a virtual one if there is depth.
struct StereoFeatures {
  std::vector<cv::KeyPoint> keypoints;  ///< left, px
  cv::Mat descriptors;                  ///< ORB: a row of 32 bytes per keypoint
  std::vector<double> u_right;          ///< column of each keypoint in the right image, px; -1: not found
  std::vector<cv::Mat> pyramid;         ///< of the left image, for Alignment
  cv::Mat depth;                        ///< of the images

  std::size_t size() const { return keypoints.size(); }
};

/// Hamming distance of two ORB descriptors, bits.
int distance(const unsigned char* a, const unsigned char* b);

/// Finds the positions in an image whose patches match those around positions in another image (Lucas & Kanade 1981),
/// px at level 0, to a tenth of a pixel; keypoints are only whole pixels of their level.
struct Alignment {
  std::vector<cv::Point2f> from;          ///< positions in one image
  std::vector<cv::Point2f> start;         ///< approximate positions in the other
  std::vector<cv::Point2f> to;            ///< found positions
  std::vector<unsigned char> is_aligned;  ///< zero where it failed or moved too far

  void clear();
  void run(const std::vector<cv::Mat>& from_pyramid, const std::vector<cv::Mat>& to_pyramid);
};

/// ORB features spread over the image, with stereo matches along rows, aligned to a fraction of a pixel, or with depth.
class FeatureExtractor {
 public:
  FeatureExtractor(const maxlogdet::PinholeCamera& camera, int count);

  StereoFeatures extract(const StereoImages& images);

 private:
  void detect(const cv::Mat& image, std::vector<cv::KeyPoint>& keypoints, cv::Mat& descriptors);
  void find_right(const cv::Mat& right_image, StereoFeatures& features);
  void take_depth(const cv::Mat& depth, StereoFeatures& features) const;

  double bf_;
  double largest_disparity_;
  std::size_t count_;
  cv::Ptr<cv::ORB> orb_;
  Alignment alignment_;
};

}  // namespace stereo_odometry
