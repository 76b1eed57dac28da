// SPDX-License-Identifier: MIT
#include "examples/stereo_odometry/local_map.hpp"

#include "sim/pose_optimizer.hpp"
#include "sim/projection.hpp"
#include "sim/statistics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace stereo_odometry {

using maxlogdet::sim::LinearizedMatch;
using maxlogdet::sim::Match;
using maxlogdet::sim::Pose;

namespace {

bool has_lower_id(const MapPointPtr& a, const MapPointPtr& b) { return a->id < b->id; }

}  // namespace

Match match_of(const MapPoint& point, const StereoFeatures& features, std::size_t keypoint, double sigma) {
  const cv::KeyPoint& k = features.keypoints[keypoint];
  Match match;
  match.keypoint = static_cast<std::int64_t>(keypoint);
  match.map_point_id = point.id;
  for (int i = 0; i < 3; ++i) match.point[i] = point.position[i];
  match.u = k.pt.x;
  match.v = k.pt.y;
  match.octave = k.octave;
  match.u_right = features.u_right[keypoint];
  match.inv_sigma2 = 1 / (sigma * sigma);
  match.desc_dist = distance(point.descriptor.data(), features.descriptors.ptr(static_cast<int>(keypoint)));
  return match;
}

bool LocalMap::needs_keyframe(const Pose& T_cw) const {
  const Keyframe& last = keyframes_.back();
  const Pose motion = T_cw * last.view->T_cw.inverse();
  return motion.translation().norm() > options_.least_parallax * last.median_depth ||
         maxlogdet::sim::rotation_angle(motion.linear()) > options_.least_rotation;
}

void LocalMap::observe(MapPoint& point, const std::shared_ptr<const View>& view, const StereoFeatures& features,
                       const Match& match) const {
  const Eigen::Vector3d ray = point.position - view->T_cw.inverse().translation();
  point.distance = ray.norm();
  point.direction = ray.normalized();
  point.octave = match.octave;
  const unsigned char* const descriptor = features.descriptors.ptr(static_cast<int>(match.keypoint));
  std::copy(descriptor, descriptor + point.descriptor.size(), point.descriptor.begin());
  point.observations.push_back({view, match});
  // The first one stays: it has the depth.
  if (point.observations.size() > options_.keyframes) point.observations.erase(point.observations.begin() + 1);
}

// Gauss-Newton on sum ||z - h(T_cw, p)||^2 inv_sigma2, all poses fixed; the covariance is the inverse of its
// information.
void LocalMap::refine(MapPoint& point) const {
  Eigen::Vector3d position = point.position;
  double least = HUGE_VAL;
  for (int step = 0; step < 3; ++step) {
    double cost = 0;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const Observation& seen : point.observations) {
      Match match = seen.match;
      for (int i = 0; i < 3; ++i) match.point[i] = position[i];
      LinearizedMatch at;
      if (!linearize(camera_, seen.view->T_cw, match, true, at)) return;
      const auto H_p = at.H_p.topRows(at.rows);
      information += match.inv_sigma2 * H_p.transpose() * H_p;
      gradient += match.inv_sigma2 * H_p.transpose() * at.residual.head(at.rows);
      cost += match.inv_sigma2 * at.residual.head(at.rows).squaredNorm();
    }
    const Eigen::Matrix3d covariance = information.inverse();
    if (!(cost <= least) || !covariance.allFinite()) return;
    least = cost;
    point.position = position;
    point.covariance = covariance;
    position += point.covariance * gradient;
  }
}

void LocalMap::add_keyframe(const Pose& T_cw, const StereoFeatures& features, const std::vector<Match>& matches,
                            const std::vector<MapPointPtr>& points) {
  Keyframe keyframe;
  keyframe.view = std::make_shared<const View>(View{next_view_++, T_cw, features.pyramid});
  keyframe.points = points;
  std::vector<char> has_point(features.size(), 0);
  for (std::size_t m = 0; m < matches.size(); ++m) {
    has_point[static_cast<std::size_t>(matches[m].keypoint)] = 1;
    observe(*points[m], keyframe.view, features, matches[m]);
    refine(*points[m]);
  }
  const Pose T_wc = T_cw.inverse();
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (has_point[i] != 0 || features.u_right[i] < 0) continue;
    const cv::Point2f& pixel = features.keypoints[i].pt;
    const double depth = camera_.bf / (pixel.x - features.u_right[i]);
    const auto point = std::make_shared<MapPoint>();
    point->id = next_id_++;
    point->position = T_wc * Eigen::Vector3d((pixel.x - camera_.cx) / camera_.fx * depth,
                                             (pixel.y - camera_.cy) / camera_.fy * depth, depth);
    observe(*point, keyframe.view, features, match_of(*point, features, i));
    refine(*point);
    keyframe.points.push_back(point);
  }
  std::vector<double> depths;
  for (const MapPointPtr& point : keyframe.points) depths.push_back((T_cw * point->position).z());
  std::sort(keyframe.points.begin(), keyframe.points.end(), has_lower_id);
  keyframe.median_depth = depths.empty() ? 0 : maxlogdet::sim::quantile_of(depths, 0.5);
  keyframes_.push_back(std::move(keyframe));
  if (keyframes_.size() > options_.keyframes) keyframes_.pop_front();

  local_points_.clear();
  for (const Keyframe& each : keyframes_) {
    local_points_.insert(local_points_.end(), each.points.begin(), each.points.end());
  }
  std::sort(local_points_.begin(), local_points_.end(), has_lower_id);
  local_points_.erase(std::unique(local_points_.begin(), local_points_.end()), local_points_.end());
}

}  // namespace stereo_odometry
