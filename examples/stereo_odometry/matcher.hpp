// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/projection_search.hpp"
#include "sim/motion_noise.hpp"
#include "sim/outlier_rejection.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stereo_odometry {

/// Matches a frame with the map: points are searched for where they should be, and what is found is aligned with the
/// image that saw them last. Keeps its memory from frame to frame.
class Matcher {
 public:
  Matcher(const maxlogdet::PinholeCamera& camera, int width, int height);

  /// What matches deviate by from here on.
  void set_noise(const maxlogdet::sim::MotionNoise& noise) { noise_ = noise; }

  /// Begins anew. The features stay the caller's.
  void start(const StereoFeatures& features);

  /// How the points that should be in view from T_cw should look; of those that a keyframe from `first_view` on has
  /// seen. Those that are matched are left out.
  std::vector<Prediction>& predict(const MapPoints& map, const maxlogdet::sim::Pose& T_cw, std::int64_t first_view = 0);

  const std::vector<Prediction>& predictions() const { return predictions_; }

  /// Searches for what is predicted: a keypoint, or ProjectionSearch::none, for each.
  const std::vector<std::int64_t>& search(double radius);

  /// Searches for all that is predicted, and adds the matches.
  void match_all(const LocalMap& map, double radius);

  /// Whether each point of the map is predicted: candidates to select from.
  const std::vector<unsigned char>& is_predicted(const MapPoints& map);

  /// Searches for `proposals`, points of the map that is_predicted() has, and adds the matches that agree with T_cw; a
  /// keypoint that two of them claim is the first one's. The result tells of each whether it is matched.
  const std::vector<unsigned char>& match_some(const LocalMap& map, const std::vector<std::uint32_t>& proposals,
                                               double radius, const maxlogdet::sim::Pose& T_cw,
                                               const maxlogdet::sim::RejectionOptions& gate);

  /// Camera, image and matches; points()[i], an index of the map, is that of match i.
  maxlogdet::sim::Frame& frame() { return frame_; }
  const std::vector<maxlogdet::sim::Match>& matches() const { return frame_.matches; }
  const std::vector<std::uint32_t>& points() const { return points_; }

 private:
  void add(const MapPoints& map, std::uint32_t point, std::int64_t keypoint);
  void align(const LocalMap& map, std::size_t first);
  void drop_unaligned(std::size_t first);

  maxlogdet::sim::MotionNoise noise_;
  const StereoFeatures* features_ = nullptr;
  maxlogdet::sim::Frame frame_;
  std::vector<std::uint32_t> points_;
  ProjectionSearch search_;
  Alignment alignment_;
  std::vector<Prediction> predictions_;
  std::vector<std::int64_t> found_;
  std::vector<unsigned char> is_predicted_;   // of the map's points
  std::vector<std::uint32_t> prediction_of_;  // of these, where there is one
  std::vector<unsigned char> is_matched_;     // of proposals, or of the map's points
  std::vector<unsigned char> is_aligned_;     // of matches
  std::vector<std::size_t> of_view_;          // matches whose points one keyframe saw last
};

}  // namespace stereo_odometry
