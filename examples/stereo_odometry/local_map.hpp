// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/features.hpp"
#include "sim/frame.hpp"
#include "sim/se3.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace stereo_odometry {

/// What is kept of a keyframe's image.
struct View {
  std::int64_t number = 0;
  maxlogdet::sim::Pose T_cw;
  std::vector<cv::Mat> pyramid;
};

/// Where a keyframe saw a point.
struct Observation {
  std::int64_t view = 0;  ///< its number
  maxlogdet::sim::Match match;
};

/// A point of the map, as its last observation has it.
struct MapPoint {
  std::int64_t id = 0;
  cv::Point2f pixel;  ///< there
  Descriptor descriptor{};
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< from the camera to the point, unit length
  double distance = 0;                                   ///< from the camera, m
  int octave = 0;
  std::vector<Observation> observations;
};

/// Points in order of id, and in arrays of their own what is read of all of them in every frame: by which they are in
/// view or not, and what append_blocks reads, which are the library's arrays. What a point is worth before it is
/// matched is multiplied by the chance that it is.
struct MapPoints {
  std::vector<MapPoint> points;
  std::vector<std::int64_t> views;           ///< number of the last keyframe that saw it
  std::vector<Eigen::Vector3d> positions;    ///< world frame, m
  std::vector<Eigen::Matrix3d> covariances;  ///< of the positions, m^2, if observations deviate by aligned_sigma
  std::vector<double> chances;               ///< that it is found again, by how many keyframes have seen it
  std::vector<unsigned char> is_stereo;      ///< whether its last keyframe had a right-image column for it

  std::size_t size() const { return points.size(); }
  maxlogdet::Matches arrays() const;

  void push_back(MapPoint point, const Eigen::Vector3d& position);
  void drop_before(std::int64_t view);  ///< those that no keyframe from there on has seen
};

struct MapOptions {
  std::size_t keyframes = 5;   ///< that the local map is made of
  double min_parallax = 0.07;  ///< keyframes differ by so much of the median depth
  double min_rotation = 0.1;   ///< or by so much, rad
};

/// The last keyframes and their points. Positions are refined with poses as they are, and poses never: there is no
/// bundle adjustment here, so errors of poses stay in the map, as a bias.
class LocalMap {
 public:
  LocalMap(const maxlogdet::PinholeCamera& camera, const MapOptions& options) : camera_(camera), options_(options) {}

  bool is_empty() const { return views_.empty(); }
  void clear();

  /// Whether a camera there sees the world from elsewhere than the last keyframe.
  bool needs_keyframe(const maxlogdet::sim::Pose& T_cw) const;

  /// Makes a keyframe; points[i] is that of matches[i], an index of points(), which are other ones afterwards. Matched
  /// points are refined, keypoints with a stereo match and no point get a new one.
  void add_keyframe(const maxlogdet::sim::Pose& T_cw, const StereoFeatures& features,
                    const std::vector<maxlogdet::sim::Match>& matches, const std::vector<std::uint32_t>& points);

  const MapPoints& points() const { return map_; }

  /// Of the keyframes, oldest first.
  const std::deque<View>& views() const { return views_; }

  /// The number of the first of the last `count` keyframes, which is that of the last for 0 as for 1, and of the oldest
  /// if there are not as many.
  std::int64_t first_of_last(std::size_t count) const {
    return views_[views_.size() - std::clamp(count, std::size_t{1}, views_.size())].number;
  }

  /// Where any keyframe was, also one that has left the map.
  const maxlogdet::sim::Pose& pose_of(std::int64_t view) const { return poses_[static_cast<std::size_t>(view)]; }

 private:
  void observe(std::size_t point, const StereoFeatures& features, const maxlogdet::sim::Match& match);
  void refine(std::size_t point);
  double median_depth() const;

  maxlogdet::PinholeCamera camera_;
  MapOptions options_;
  MapPoints map_;
  std::deque<View> views_;
  std::vector<maxlogdet::sim::Pose> poses_;  // of all keyframes ever, by number: first observations outlive their views
  double median_depth_ = 0;                  // of the points of the last
  std::int64_t next_id_ = 0;
};

/// A keypoint matched with a point, as the selectors and the optimiser take it; `sigma`: deviation of its place, px.
maxlogdet::sim::Match match_of(const MapPoints& map, std::size_t point, const StereoFeatures& features,
                               std::size_t keypoint, double sigma = aligned_sigma);

}  // namespace stereo_odometry
