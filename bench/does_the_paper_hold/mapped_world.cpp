// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/mapped_world.hpp"

#include "bench/world/scene.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::sim {
namespace {

constexpr double nearest = 0.5;  // m: closer points are not matched
constexpr double border = 16;    // px, where ORB finds no corners
constexpr double scale_factor = 1.2;
constexpr int octaves = 8;

// A keyframe is inserted after 0.25 m or 10 degrees, or when less than 60 % of the landmarks in view are mapped; never
// two within 5 frames.
constexpr double keyframe_distance = 0.25;
constexpr double keyframe_angle = 10 * radians;
constexpr double keyframe_share = 0.6;
constexpr std::size_t keyframe_gap = 5;
constexpr double mapping_rate = 0.8;  // share of the new landmarks that a keyframe triangulates
constexpr std::uint32_t memory = 10;  // keyframes until a landmark out of view is forgotten

// Distances from the trajectory, m: walls; floor and ceiling.
constexpr double wall_distance = 2.5;
constexpr double floor_distance = 1.5;

Eigen::Vector2d project(const Eigen::Vector3d& p_c) {
  return {euroc_camera.fx * p_c.x() / p_c.z() + euroc_camera.cx, euroc_camera.fy * p_c.y() / p_c.z() + euroc_camera.cy};
}

}  // namespace

Pose euroc_T_bc() {
  return pose_of({0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,  //
                  0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,      //
                  -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949});
}

MappedWorld::MappedWorld(const Trajectory& trajectory, const WorldOptions& options, std::uint64_t seed)
    : trajectory_(trajectory), options_(options), draws_(seed) {
  scatter_landmarks();
}

// In a box around the trajectory: two thirds on its six faces in proportion to their area, one third inside; half of
// all in clusters, like texture.
void MappedWorld::scatter_landmarks() {
  Eigen::Vector3d low = trajectory_.poses.front().T_wb.translation();
  Eigen::Vector3d high = low;
  for (const StampedPose& pose : trajectory_.poses) {
    low = low.cwiseMin(pose.T_wb.translation());
    high = high.cwiseMax(pose.T_wb.translation());
  }
  const Eigen::Vector3d margin(wall_distance, wall_distance, floor_distance);
  low -= margin;
  high += margin;
  const Eigen::Vector3d size = high - low;
  const Eigen::Vector3d area(size.y() * size.z(), size.x() * size.z(), size.x() * size.y());

  const auto place = [&] {
    Eigen::Vector3d p;
    for (int i = 0; i < 3; ++i) p[i] = draws_.uniform(low[i], high[i]);
    if (draws_.chance(1.0 / 3)) return p;
    const double pick = draws_.uniform(0, area.sum());
    const int axis = pick < area.x() ? 0 : pick < area.x() + area.y() ? 1 : 2;
    p[axis] = draws_.chance(0.5) ? low[axis] : high[axis];
    return p;
  };
  std::vector<Eigen::Vector3d> clusters;
  for (std::size_t i = 0; i < options_.landmarks / 100 + 1; ++i) clusters.push_back(place());

  constexpr double cluster_size = 0.2;  // m
  landmarks_.resize(options_.landmarks);
  for (Landmark& landmark : landmarks_) {
    landmark.position = draws_.chance(0.5) ? place() : clusters[draws_.below(clusters.size())];
    landmark.position += draws_.normal3(cluster_size);
    landmark.octave = static_cast<int>(draws_.below(octaves));
    landmark.reference_depth = draws_.uniform(2, 8);
  }
}

bool MappedWorld::next(Frame& frame) {
  if (frame_ == trajectory_.poses.size()) return false;
  T_cw_ = (trajectory_.poses[frame_].T_wb * T_bc_).inverse();
  find_visible();
  if (needs_keyframe()) insert_keyframe();

  frame.camera = euroc_camera;
  frame.width = euroc_width;
  frame.height = euroc_height;
  frame.matches.clear();
  std::vector<std::uint32_t> matched;
  for (const std::uint32_t id : visible_) {
    if (landmarks_[id].batch != 0 && draws_.chance(options_.detection_rate)) matched.push_back(id);
  }
  if (matched.size() > options_.max_matches) {
    draws_.shuffle_front(matched, options_.max_matches);
    matched.resize(options_.max_matches);
    std::sort(matched.begin(), matched.end());
  }
  for (const std::uint32_t id : matched) frame.matches.push_back(match_of(id, landmarks_[id]));
  ++frame_;
  return true;
}

void MappedWorld::find_visible() {
  visible_.clear();
  mapped_in_view_ = 0;
  const Eigen::Matrix3d R = T_cw_.rotation();
  const Eigen::Vector3d t = T_cw_.translation();
  for (std::uint32_t id = 0; id < landmarks_.size(); ++id) {
    Landmark& landmark = landmarks_[id];
    const Eigen::Vector3d p_c = R * landmark.position + t;
    if (p_c.z() < nearest) continue;
    const Eigen::Vector2d uv = project(p_c);
    if (uv.x() < border || uv.y() < border || uv.x() > euroc_width - border || uv.y() > euroc_height - border) continue;
    visible_.push_back(id);
    if (landmark.batch != 0 && keyframes_ - landmark.last_seen > memory) landmark.batch = 0;
    landmark.last_seen = keyframes_;
    if (landmark.batch != 0) ++mapped_in_view_;
  }
}

bool MappedWorld::needs_keyframe() const {
  if (keyframes_ == 0) return true;
  if (frame_ - keyframe_frame_ < keyframe_gap) return false;
  const Pose motion = T_cw_ * keyframe_T_cw_.inverse();
  return motion.translation().norm() > keyframe_distance || rotation_angle(motion.rotation()) > keyframe_angle ||
         static_cast<double>(mapped_in_view_) < keyframe_share * static_cast<double>(visible_.size());
}

void MappedWorld::insert_keyframe() {
  ++keyframes_;
  keyframe_T_cw_ = T_cw_;
  keyframe_frame_ = frame_;
  const BatchError error = next_batch_error();
  for (const std::uint32_t id : visible_) {
    Landmark& landmark = landmarks_[id];
    landmark.last_seen = keyframes_;
    if (landmark.batch != 0 || !draws_.chance(mapping_rate)) continue;
    landmark.batch = keyframes_;
    landmark.mapped = as_mapped(landmark, error);
  }
}

// e <- rho e + sqrt(1 - rho^2) N(0, sigma^2): the deviation stays sigma.
MappedWorld::BatchError MappedWorld::next_batch_error() {
  const double rho = keyframes_ == 1 ? 0 : options_.batch_correlation;
  const double fresh = std::sqrt(1 - rho * rho);
  batch_error_.translation = rho * batch_error_.translation + fresh * draws_.normal3(options_.batch_translation);
  batch_error_.rotation = rho * batch_error_.rotation + fresh * draws_.normal3(options_.batch_rotation_deg * radians);
  batch_error_.scale = rho * batch_error_.scale + fresh * options_.batch_scale * draws_.normal();
  return batch_error_;
}

// In the keyframe's camera frame: the error of triangulation, then of scale, then of the keyframe's pose.
Eigen::Vector3d MappedWorld::as_mapped(const Landmark& landmark, const BatchError& error) {
  Eigen::Vector3d p_c = T_cw_ * landmark.position;
  const double depth = p_c.z();
  const Eigen::Vector3d across = draws_.normal3(options_.lateral_sigma * depth);
  const double along = draws_.normal() * std::min(options_.depth_sigma * depth * depth, 0.2 * depth);
  p_c += across + along / depth * p_c;
  p_c *= 1 + error.scale;
  Vector6 xi;
  xi << error.translation, error.rotation;
  return T_cw_.inverse() * (exp_se3(xi) * p_c);
}

Match MappedWorld::match_of(std::uint32_t id, const Landmark& landmark) {
  const Eigen::Vector3d p_c = T_cw_ * landmark.position;
  const Eigen::Vector2d uv = project(p_c);
  Match match;
  match.keypoint = id;
  match.map_point_id = id;
  match.keyframe = landmark.batch;
  for (int i = 0; i < 3; ++i) match.point[i] = landmark.mapped[i];
  const double levels = std::log(landmark.reference_depth / p_c.z()) / std::log(scale_factor);
  match.octave = std::clamp(landmark.octave + static_cast<int>(std::lround(levels)), 0, octaves - 1);
  const double scale = std::pow(scale_factor, match.octave);
  match.inv_sigma2 = 1 / (scale * scale);  // a tracker assumes 1 px at octave 0

  const double sigma = options_.pixel_sigma * scale;
  const double error_v = draws_.normal(), error_u = draws_.normal();
  Eigen::Vector2d error(error_u, error_v);
  double quality = 30 + 5 * error.norm() + 12 * draws_.normal();
  error *= sigma;
  if (draws_.chance(options_.outlier_rate)) {
    const double angle = 360 * radians * draws_.uniform(0, 1);
    error = draws_.uniform(5, 40) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    quality += 15;
  }
  match.u = uv.x() + error.x();
  match.v = uv.y() + error.y();
  match.desc_dist = std::round(std::clamp(quality, 0.0, 256.0));
  return match;
}

}  // namespace maxlogdet::sim
