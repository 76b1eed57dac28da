// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/projection_search.hpp"
#include "bench/world/motion_noise.hpp"
#include "bench/world/outlier_rejection.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stereo_odometry {

/// Matches a frame with the map: searches for points at their projections, and aligns the matches with the image that
/// observed them last. Reuses its memory.
class Matcher {
 public:
  Matcher(const maxlogdet::PinholeCamera& camera, int width, int height);

  /// The noise of the matches from now on.
  void set_noise(const maxlogdet::sim::MotionNoise& noise) { noise_ = noise; }

  /// Starts a frame; keeps a pointer to the features.
  void start(const StereoFeatures& features);

  /// Predicts the appearance from T_cw of the points that a keyframe from `first_view` on has seen and that are not
  /// matched.
  std::vector<Prediction>& predict(const MapPoints& map, const maxlogdet::sim::Pose& T_cw, std::int64_t first_view = 0);

  const std::vector<Prediction>& predictions() const { return predictions_; }

  /// Searches for all predictions; returns a keypoint or ProjectionSearch::none for each.
  const std::vector<std::int64_t>& search(double radius);

  /// Searches for all predictions, and adds the matches.
  void match_all(const LocalMap& map, double radius);

  /// Whether each point of the map is predicted: these are the candidates.
  const std::vector<unsigned char>& is_predicted(const MapPoints& map);

  /// Searches for `proposals`, predicted points of the map, and adds the matches that agree with T_cw; if two claim a
  /// keypoint, the first one gets it. Returns whether each proposal is matched.
  const std::vector<unsigned char>& match_some(const LocalMap& map, const std::vector<std::uint32_t>& proposals,
                                               double radius, const maxlogdet::sim::Pose& T_cw,
                                               const maxlogdet::sim::RejectionOptions& gate);

  /// Camera, image and matches; points()[i] is the index in the map of the point of match i.
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
  std::vector<std::uint32_t> prediction_of_;  // its index in predictions_, if it is predicted
  std::vector<unsigned char> is_matched_;     // of proposals, or of the map's points
  std::vector<unsigned char> is_aligned_;     // of matches
  std::vector<std::size_t> of_view_;          // matches whose points one keyframe observed last
};

}  // namespace stereo_odometry
