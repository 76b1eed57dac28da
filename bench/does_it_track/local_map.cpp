// SPDX-License-Identifier: MIT
#include "bench/does_it_track/local_map.hpp"

#include "bench/world/pose_optimizer.hpp"
#include "bench/world/projection.hpp"
#include "bench/world/statistics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace stereo_odometry {

using maxlogdet::sim::LinearizedMatch;
using maxlogdet::sim::Match;
using maxlogdet::sim::Pose;

maxlogdet::Matches MapPoints::arrays() const {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) && sizeof(Eigen::Matrix3d) == 9 * sizeof(double));
  maxlogdet::Matches matches;
  matches.size = size();
  if (matches.size == 0) return matches;
  matches.points = positions.front().data();
  matches.map_covariances = covariances.front().data();
  matches.weights = chances.data();
  matches.has_depth_cue = is_stereo.data();
  return matches;
}

void MapPoints::push_back(MapPoint point, const Eigen::Vector3d& position) {
  points.push_back(std::move(point));
  views.push_back(0);
  positions.push_back(position);
  covariances.emplace_back(Eigen::Matrix3d::Identity());
  chances.push_back(0);
  is_stereo.push_back(0);
}

void MapPoints::drop_before(std::int64_t view) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    if (views[i] < view) continue;
    views[kept] = views[i];
    if (kept != i) points[kept] = std::move(points[i]);
    positions[kept] = positions[i];
    covariances[kept] = covariances[i];
    chances[kept] = chances[i];
    is_stereo[kept++] = is_stereo[i];
  }
  points.resize(kept);
  views.resize(kept);
  positions.resize(kept);
  covariances.resize(kept);
  chances.resize(kept);
  is_stereo.resize(kept);
}

Match match_of(const MapPoints& map, std::size_t point, const StereoFeatures& features, std::size_t keypoint,
               double sigma) {
  const cv::KeyPoint& k = features.keypoints[keypoint];
  Match match;
  match.keypoint = static_cast<std::int64_t>(keypoint);
  match.map_point_id = map.points[point].id;
  if (!map.points[point].observations.empty()) match.keyframe = map.points[point].observations.front().view;
  for (int i = 0; i < 3; ++i) match.point[i] = map.positions[point][i];
  match.u = k.pt.x;
  match.v = k.pt.y;
  match.octave = k.octave;
  match.u_right = features.u_right[keypoint];
  match.inv_sigma2 = 1 / (sigma * sigma);
  match.desc_dist = distance(map.points[point].descriptor.data(), features.descriptors.ptr(static_cast<int>(keypoint)));
  return match;
}

void LocalMap::clear() {
  views_.clear();
  map_ = {};
}

bool LocalMap::needs_keyframe(const Pose& T_cw) const {
  const Pose motion = T_cw * views_.back().T_cw.inverse();
  return motion.translation().norm() > options_.min_parallax * median_depth_ ||
         maxlogdet::sim::rotation_angle(motion.linear()) > options_.min_rotation;
}

// Adds an observation of the last keyframe.
void LocalMap::observe(std::size_t point, const StereoFeatures& features, const Match& match) {
  const View& view = views_.back();
  MapPoint& seen = map_.points[point];
  const Eigen::Vector3d ray = map_.positions[point] - view.T_cw.inverse().translation();
  map_.views[point] = view.number;
  seen.pixel = {static_cast<float>(match.u), static_cast<float>(match.v)};
  seen.distance = ray.norm();
  seen.direction = ray.normalized();
  seen.octave = match.octave;
  const unsigned char* const descriptor = features.descriptors.ptr(static_cast<int>(match.keypoint));
  std::copy(descriptor, descriptor + seen.descriptor.size(), seen.descriptor.begin());
  map_.is_stereo[point] = match.is_stereo() ? 1 : 0;
  seen.observations.push_back({view.number, match});
  seen.observations.back().match.inv_sigma2 = 1 / (aligned_sigma * aligned_sigma);
  // Keeps the first observation, which has the depth.
  if (seen.observations.size() > options_.keyframes) seen.observations.erase(seen.observations.begin() + 1);
  const auto observations = static_cast<double>(seen.observations.size());
  map_.chances[point] = observations / (observations + 2);  // 0.33 to 0.71; measured on two KITTI clips: 0.27 to 0.79
}

// Gauss-Newton on sum ||z - h(T_cw, p)||^2 inv_sigma2 with all poses fixed; the covariance is the inverse information.
void LocalMap::refine(std::size_t point) {
  Eigen::Vector3d position = map_.positions[point];
  double lowest = HUGE_VAL;
  for (int step = 0; step < 3; ++step) {
    double cost = 0;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const Observation& seen : map_.points[point].observations) {
      Match match = seen.match;
      for (int i = 0; i < 3; ++i) match.point[i] = position[i];
      LinearizedMatch at;
      if (!linearize(camera_, pose_of(seen.view), match, true, at)) return;
      const auto H_p = at.H_p.topRows(at.rows);
      information += match.inv_sigma2 * H_p.transpose() * H_p;
      gradient += match.inv_sigma2 * H_p.transpose() * at.residual.head(at.rows);
      cost += match.inv_sigma2 * at.residual.head(at.rows).squaredNorm();
    }
    const Eigen::Matrix3d covariance = information.inverse();
    if (!(cost <= lowest) || !covariance.allFinite()) return;
    lowest = cost;
    map_.positions[point] = position;
    map_.covariances[point] = covariance;
    position += covariance * gradient;
  }
}

double LocalMap::median_depth() const {
  std::vector<double> depths;
  for (std::size_t i = 0; i < map_.size(); ++i) {
    if (map_.views[i] == views_.back().number) depths.push_back((views_.back().T_cw * map_.positions[i]).z());
  }
  return depths.empty() ? 0 : maxlogdet::sim::quantile_of(depths, 0.5);
}

void LocalMap::add_keyframe(const Pose& T_cw, const StereoFeatures& features, const std::vector<Match>& matches,
                            const std::vector<std::uint32_t>& points) {
  views_.push_back({static_cast<std::int64_t>(poses_.size()), T_cw, features.pyramid});
  poses_.push_back(T_cw);
  if (views_.size() > options_.keyframes) views_.pop_front();
  std::vector<char> has_point(features.size(), 0);
  for (std::size_t m = 0; m < matches.size(); ++m) {
    has_point[static_cast<std::size_t>(matches[m].keypoint)] = 1;
    observe(points[m], features, matches[m]);
    refine(points[m]);
  }
  const Pose T_wc = T_cw.inverse();
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (has_point[i] != 0 || features.u_right[i] < 0) continue;
    const cv::Point2f& pixel = features.keypoints[i].pt;
    const double depth = camera_.bf / (pixel.x - features.u_right[i]);
    MapPoint point;
    point.id = next_id_++;
    map_.push_back(std::move(point), T_wc * Eigen::Vector3d((pixel.x - camera_.cx) / camera_.fx * depth,
                                                            (pixel.y - camera_.cy) / camera_.fy * depth, depth));
    observe(map_.size() - 1, features, match_of(map_, map_.size() - 1, features, i));
    refine(map_.size() - 1);
  }
  map_.drop_before(views_.front().number);
  median_depth_ = median_depth();
}

}  // namespace stereo_odometry
