// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/features.hpp"
#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace stereo_odometry {

/// A keyframe.
struct View {
  std::int64_t number = 0;
  maxlogdet::sim::Pose T_cw;
  std::vector<cv::Mat> pyramid;
};

/// An observation of a point in a keyframe.
struct Observation {
  std::int64_t view = 0;  ///< number of the keyframe
  maxlogdet::sim::Match match;
};

/// A point of the map, as last observed.
struct MapPoint {
  std::int64_t id = 0;
  cv::Point2f pixel;  ///< in that keyframe
  Descriptor descriptor{};
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< from the camera to the point, unit length
  double distance = 0;                                   ///< from the camera, m
  int octave = 0;
  std::vector<Observation> observations;
};

/// Points in order of id. What every frame reads of all points is in separate arrays: for the test whether they are in
/// view, and for append_blocks, in the library's layout. The weight of a point before it is matched is the probability
/// that it will be.
struct MapPoints {
  std::vector<MapPoint> points;
  std::vector<std::int64_t> views;           ///< number of the last keyframe that observed it
  std::vector<Eigen::Vector3d> positions;    ///< world frame, m
  std::vector<Eigen::Matrix3d> covariances;  ///< of the positions, m^2, for deviations of aligned_sigma
  std::vector<double> chances;               ///< of being found again, by the number of its observations
  std::vector<unsigned char> is_stereo;      ///< whether its last keyframe had a right-image column

  std::size_t size() const { return points.size(); }
  maxlogdet::Matches arrays() const;

  void push_back(MapPoint point, const Eigen::Vector3d& position);
  void drop_before(std::int64_t view);  ///< removes points not observed from there on
};

struct MapOptions {
  std::size_t keyframes = 5;   ///< of the local map
  double min_parallax = 0.07;  ///< between keyframes, as a fraction of the median depth
  double min_rotation = 0.1;   ///< or between keyframes, rad
};

/// The last keyframes and their points. Positions are refined with fixed poses, and poses never, because there is no
/// bundle adjustment here: errors of poses stay in the map as a bias.
class LocalMap {
 public:
  LocalMap(const maxlogdet::PinholeCamera& camera, const MapOptions& options) : camera_(camera), options_(options) {}

  bool is_empty() const { return views_.empty(); }
  void clear();

  /// Whether the view from T_cw differs enough from that of the last keyframe.
  bool needs_keyframe(const maxlogdet::sim::Pose& T_cw) const;

  /// Adds a keyframe; points[i] is the index of the point of matches[i], and indices change. Refines matched points,
  /// and adds a point for each keypoint with a stereo match and without a point.
  void add_keyframe(const maxlogdet::sim::Pose& T_cw, const StereoFeatures& features,
                    const std::vector<maxlogdet::sim::Match>& matches, const std::vector<std::uint32_t>& points);

  const MapPoints& points() const { return map_; }

  /// The keyframes, oldest first.
  const std::deque<View>& views() const { return views_; }

  /// The number of the first of the last `count` keyframes, clamped to those that exist.
  std::int64_t first_of_last(std::size_t count) const {
    return views_[views_.size() - std::clamp(count, std::size_t{1}, views_.size())].number;
  }

  /// The pose of any keyframe, also of one that has left the map.
  const maxlogdet::sim::Pose& pose_of(std::int64_t view) const { return poses_[static_cast<std::size_t>(view)]; }

 private:
  void observe(std::size_t point, const StereoFeatures& features, const maxlogdet::sim::Match& match);
  void refine(std::size_t point);
  double median_depth() const;

  maxlogdet::PinholeCamera camera_;
  MapOptions options_;
  MapPoints map_;
  std::deque<View> views_;
  std::vector<maxlogdet::sim::Pose> poses_;  // of all keyframes by number: first observations outlive their views
  double median_depth_ = 0;                  // of the points of the last keyframe
  std::int64_t next_id_ = 0;
};

/// The match of a keypoint with a point, for selectors and optimiser; `sigma`: standard deviation of the keypoint, px.
maxlogdet::sim::Match match_of(const MapPoints& map, std::size_t point, const StereoFeatures& features,
                               std::size_t keypoint, double sigma = aligned_sigma);

}  // namespace stereo_odometry
