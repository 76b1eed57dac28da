// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/local_map.hpp"

#include <cstdint>
#include <vector>

namespace stereo_odometry {

/// A point as it should look from a pose.
struct Prediction {
  std::uint32_t point = 0;           ///< its index in the map
  int octave = 0;                    ///< of the keypoint
  double u = 0, v = 0, u_right = 0;  ///< px
  Descriptor descriptor{};
};

/// The points in front of the camera, in the image, from not too far off where they were seen before, in their order;
/// of those that a keyframe from `first_view` on has seen.
void find_points_in_view(const MapPoints& map, std::int64_t first_view, const maxlogdet::PinholeCamera& camera,
                         int width, int height, const maxlogdet::sim::Pose& T_cw, std::vector<Prediction>& result);

/// Keypoints by place, to search around projections.
class ProjectionSearch {
 public:
  ProjectionSearch(int width, int height);

  static constexpr std::int64_t none = -1;

  /// Begins anew with the keypoints of an image. The features stay the caller's.
  void start(const StereoFeatures& features);

  /// The keypoint most like the point within `radius` times its level's scale, px; none if it is not like it enough, or
  /// another one is nearly as like. Keypoints that are taken are passed by.
  std::int64_t find(const Prediction& prediction, double radius) const;

  /// Searches all; of several points that claim one keypoint the most like gets it. found[i]: of predictions[i].
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
  std::vector<Keypoint> keypoints_;      // cell by cell
  std::vector<std::uint32_t> cell_end_;  // of them, a cell each; cell 0 begins at 0
  std::vector<char> is_taken_;
  std::vector<std::int64_t> claimed_by_;
};

}  // namespace stereo_odometry
