// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/local_map.hpp"

#include <cstdint>
#include <vector>

namespace stereo_odometry {

/// A point as it should look from a pose.
struct Prediction {
  MapPointPtr point;
  double u = 0, v = 0, u_right = 0;  ///< px
  int octave = 0;
};

/// The points in front of the camera, in the image, from not too far off where they were seen before.
std::vector<Prediction> points_in_view(const std::vector<MapPointPtr>& points, const maxlogdet::PinholeCamera& camera,
                                       int width, int height, const maxlogdet::sim::Pose& T_cw);

/// Keypoints by place, to search around projections. The features stay the caller's.
class ProjectionSearch {
 public:
  ProjectionSearch(const StereoFeatures& features, int width, int height);

  static constexpr std::int64_t none = -1;

  /// The keypoint most like the point within `radius` times its level's scale, px; none if it is not like it enough, or
  /// another one is nearly as like. Keypoints that are taken are passed by.
  std::int64_t find(const Prediction& prediction, double radius) const;

  /// Searches all; of several points that claim one keypoint the most like gets it. result[i]: of predictions[i].
  std::vector<std::int64_t> find_all(const std::vector<Prediction>& predictions, double radius) const;

  void take(std::int64_t keypoint) { is_taken_[static_cast<std::size_t>(keypoint)] = 1; }

 private:
  const StereoFeatures& features_;
  int columns_, rows_;
  std::vector<std::vector<int>> cells_;
  std::vector<char> is_taken_;
};

}  // namespace stereo_odometry
