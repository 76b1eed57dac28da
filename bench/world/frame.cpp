// SPDX-License-Identifier: MIT
#include "bench/world/frame.hpp"

#include <cmath>

namespace maxlogdet::sim {

DepthCue FrameCamera::depth_cue() const noexcept {
  if (depth_sigma > 0) return DepthCue::depth;
  return rig.empty() && bf > 0 ? DepthCue::stereo : DepthCue::none;
}

void fill_unknown_covariances(Frame& frame, double map_sigma) {
  const double variance = map_sigma * map_sigma;
  for (auto& covariance : frame.map_covariances) {
    if (std::isnan(covariance[0])) covariance = {variance, 0, 0, 0, variance, 0, 0, 0, variance};
  }
}

FeatureMatch feature_match(const Match& match, DepthCue depth_cue) {
  const double uv[2] = {match.u, match.v};
  FeatureMatch made(match.point, uv, 1 / std::sqrt(match.inv_sigma2));
  if (depth_cue == DepthCue::stereo) made.u_right = match.u_right;
  if (depth_cue == DepthCue::depth) made.depth = match.depth;
  made.camera_id = match.camera_id;
  return made;
}

std::array<double, 3> in_camera(const Frame& frame, const Match& match) {
  std::array<double, 3> p{};
  RigidTransform::row_major(frame.T_cw_prior.data()).transform(match.point, p.data());
  if (frame.camera.rig.empty()) return p;
  std::array<double, 3> of_camera{};
  frame.camera.rig[match.camera_id].T_cb.transform(p.data(), of_camera.data());
  return of_camera;
}

MatchArrays::MatchArrays(const Frame& frame, const std::vector<std::uint32_t>& subset) {
  for (const std::uint32_t i : subset) add(frame, i);
}

void MatchArrays::assign(const Frame& frame) {
  clear();
  for (std::size_t i = 0; i < frame.matches.size(); ++i) add(frame, i);
}

void MatchArrays::clear() {
  points_.clear();
  sigmas_.clear();
  map_covariances_.clear();
  has_depth_cue_.clear();
  camera_ids_.clear();
}

void MatchArrays::add(const Frame& frame, std::size_t i) {
  add(frame.matches[i], frame.map_covariances.empty() ? nullptr : frame.map_covariances[i].data());
  if (!frame.camera.rig.empty()) camera_ids_.push_back(frame.matches[i].camera_id);
}

void MatchArrays::add(const Match& match, const double* map_covariance) {
  points_.insert(points_.end(), match.point, match.point + 3);
  sigmas_.push_back(1 / std::sqrt(match.inv_sigma2));
  has_depth_cue_.push_back(match.has_depth_cue() ? 1 : 0);
  if (map_covariance != nullptr) map_covariances_.insert(map_covariances_.end(), map_covariance, map_covariance + 9);
}

Matches MatchArrays::view() const noexcept {
  Matches matches;
  matches.size = sigmas_.size();
  matches.points = points_.data();
  matches.sigmas = sigmas_.data();
  matches.has_depth_cue = has_depth_cue_.data();
  if (!camera_ids_.empty()) matches.camera_ids = camera_ids_.data();
  matches.map_covariances = map_covariances_.empty() ? nullptr : map_covariances_.data();
  return matches;
}

BlockReport append_blocks(const Frame& frame, const Matches& matches, const BlockOptions& options, BlockStore& blocks) {
  const FrameCamera& camera = frame.camera;
  const RigidTransform T = RigidTransform::row_major(frame.T_cw_prior.data());
  if (camera.rig.empty()) return maxlogdet::append_blocks(Camera(camera), T, matches, options, blocks);
  return maxlogdet::append_blocks(camera.rig.data(), camera.rig.size(), T, matches, options, blocks);
}

BlockReport build_blocks(const Frame& frame, const MatchArrays& matches, const BlockOptions& options,
                         BlockStore& blocks) {
  blocks.clear();
  return append_blocks(frame, matches.view(), options, blocks);
}

BlockReport build_blocks(const Frame& frame, const BlockOptions& options, BlockStore& blocks) {
  return build_blocks(frame, MatchArrays(frame), options, blocks);
}

}  // namespace maxlogdet::sim
