// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/features.hpp"
#include "sim/frame.hpp"
#include "sim/se3.hpp"

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <deque>
#include <memory>
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
  std::shared_ptr<const View> view;
  maxlogdet::sim::Match match;
};

/// A point of the map, its position m in the world frame.
struct MapPoint {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of the position, m^2, as far as pixel noise goes
  std::array<unsigned char, 32> descriptor{};                ///< of its last observation, and so the next three
  Eigen::Vector3d direction;                                 ///< from the camera to the point, unit length
  double distance = 0;                                       ///< from the camera, m
  int octave = 0;
  std::vector<Observation> observations;
};

using MapPointPtr = std::shared_ptr<MapPoint>;

struct MapOptions {
  std::size_t keyframes = 5;     ///< that the local map is made of
  double least_parallax = 0.07;  ///< keyframes differ by so much of the median depth
  double least_rotation = 0.1;   ///< or by so much, rad
};

/// The last keyframes and their points. Positions are refined with poses as they are, and poses never: there is no
/// bundle adjustment here, so errors of poses stay in the map, as a bias.
class LocalMap {
 public:
  LocalMap(const maxlogdet::PinholeCamera& camera, const MapOptions& options) : camera_(camera), options_(options) {}

  bool is_empty() const { return keyframes_.empty(); }
  void clear() { keyframes_.clear(); }

  /// Whether a camera there sees the world from elsewhere than the last keyframe.
  bool needs_keyframe(const maxlogdet::sim::Pose& T_cw) const;

  /// Makes a keyframe; points[i] is that of matches[i]. Matched points are refined, keypoints with a stereo match
  /// and no point get a new one.
  void add_keyframe(const maxlogdet::sim::Pose& T_cw, const StereoFeatures& features,
                    const std::vector<maxlogdet::sim::Match>& matches, const std::vector<MapPointPtr>& points);

  /// Points of the last keyframe, and of all of them, both in order of id.
  const std::vector<MapPointPtr>& reference_points() const { return keyframes_.back().points; }
  const std::vector<MapPointPtr>& local_points() const { return local_points_; }

 private:
  struct Keyframe {
    std::shared_ptr<const View> view;
    std::vector<MapPointPtr> points;
    double median_depth = 0;
  };

  void observe(MapPoint& point, const std::shared_ptr<const View>& view, const StereoFeatures& features,
               const maxlogdet::sim::Match& match) const;
  void refine(MapPoint& point) const;

  maxlogdet::PinholeCamera camera_;
  MapOptions options_;
  std::deque<Keyframe> keyframes_;
  std::vector<MapPointPtr> local_points_;
  std::int64_t next_id_ = 0;
  std::int64_t next_view_ = 0;
};

/// A keypoint matched with a point, as the selectors and the optimiser take it; `sigma`: deviation of its place, px.
maxlogdet::sim::Match match_of(const MapPoint& point, const StereoFeatures& features, std::size_t keypoint,
                               double sigma = aligned_sigma);

}  // namespace stereo_odometry
