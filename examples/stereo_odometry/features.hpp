// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/dataset.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

namespace stereo_odometry {

/// The ORB pyramid: level l is smaller by scale_factor^l, and so much less is known of where a keypoint of it is.
constexpr double scale_factor = 1.2;
constexpr int pyramid_levels = 8;
double scale_of(int octave);

/// Deviation of a place that align() found, px.
constexpr double aligned_sigma = 0.5;

/// Keypoints of the left image and where the right image has them.
struct StereoFeatures {
  std::vector<cv::KeyPoint> keypoints;  ///< left, px
  cv::Mat descriptors;                  ///< a row a keypoint, 32 bytes: ORB
  std::vector<double> u_right;          ///< a keypoint's column in the right image, px; -1: not found
  std::vector<cv::Mat> pyramid;         ///< left image, as align() takes it

  std::size_t size() const { return keypoints.size(); }
};

/// Hamming distance of two ORB descriptors, bits.
int distance(const unsigned char* a, const unsigned char* b);

/// Moves each point of `to` to where its surroundings look most like those of its partner in `from` (Lucas & Kanade
/// 1981), px at level 0: a keypoint stands on a whole pixel of its level, this is good to a tenth of a pixel. False
/// where that fails, or leads far away.
std::vector<char> align(const std::vector<cv::Mat>& from_pyramid, const std::vector<cv::Mat>& to_pyramid,
                        const std::vector<cv::Point2f>& from, std::vector<cv::Point2f>& to);

/// ORB spread over the image, and stereo matches along rows, aligned to a fraction of a pixel.
class FeatureExtractor {
 public:
  FeatureExtractor(const maxlogdet::PinholeCamera& camera, int count);

  StereoFeatures extract(const StereoImages& images);

 private:
  void detect(const cv::Mat& image, std::vector<cv::KeyPoint>& keypoints, cv::Mat& descriptors);

  double largest_disparity_;
  std::size_t count_;
  cv::Ptr<cv::ORB> orb_;
};

}  // namespace stereo_odometry
