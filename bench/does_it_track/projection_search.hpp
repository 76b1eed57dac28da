// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/local_map.hpp"

#include <cstdint>
#include <vector>

namespace stereo_odometry {

/// The predicted appearance of a point from a pose.
struct Prediction {
  std::uint32_t point = 0;           ///< its index in the map
  int octave = 0;                    ///< of the keypoint
  double u = 0, v = 0, u_right = 0;  ///< px
  Descriptor descriptor{};
};

/// Finds the points that a keyframe from `first_view` on has seen, that are in front of the camera and in the image,
/// and that appear at a similar angle and distance as before; in their order.
void find_points_in_view(const MapPoints& map, std::int64_t first_view, const maxlogdet::PinholeCamera& camera,
                         int width, int height, const maxlogdet::sim::Pose& T_cw, std::vector<Prediction>& result);

/// Keypoints in cells of the image, to search around projections.
class ProjectionSearch {
 public:
  ProjectionSearch(int width, int height);

  static constexpr std::int64_t none = -1;

  /// Starts with the keypoints of an image; keeps a pointer to the features.
  void start(const StereoFeatures& features);

  /// The keypoint with the smallest distance of descriptors within `radius` times the scale of the level, px; none if
  /// that distance is large, or another one's is nearly as small. Skips keypoints that are taken.
  std::int64_t find(const Prediction& prediction, double radius) const;

  /// Searches for all; if several points claim one keypoint, the one with the smallest distance gets it.
  void find_all(const std::vector<Prediction>& predictions, double radius, std::vector<std::int64_t>& found);

  void take(std::int64_t keypoint) { is_taken_[static_cast<std::size_t>(keypoint)] = 1; }
  void give_back(std::int64_t keypoint) { is_taken_[static_cast<std::size_t>(keypoint)] = 0; }

 private:
  struct Keypoint {
    float u, v;
    double u_right;
    int octave, index;
  };

  std::size_t cell_of(const cv::Point2f& pixel) const;

  const StereoFeatures* features_ = nullptr;
  int columns_, rows_;
  std::vector<Keypoint> keypoints_;      // sorted by cell
  std::vector<std::uint32_t> cell_end_;  // of each cell in keypoints_; cell 0 begins at 0
  std::vector<char> is_taken_;
  std::vector<std::int64_t> claimed_by_;
};

}  // namespace stereo_odometry
