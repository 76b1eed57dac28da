// SPDX-License-Identifier: MIT
#include "bench/world/frame.hpp"

#include <algorithm>
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

std::uint32_t ImageGrid::cell_of(const Frame& frame, const Match& match) const {
  const auto part = [](double pixel, double size, int parts) {
    const double position = pixel / (size > 0 ? size : 1) * parts;
    return position > 0 ? static_cast<int>(std::min<double>(position, parts - 1)) : 0;
  };
  return static_cast<std::uint32_t>(columns * part(match.v - frame.top, frame.height, rows) +
                                    part(match.u - frame.left, frame.width, columns));
}

MatchArrays::MatchArrays(const Frame& frame) {
  for (std::size_t i = 0; i < frame.matches.size(); ++i) add(frame, i);
}

MatchArrays::MatchArrays(const Frame& frame, const std::vector<std::uint32_t>& subset) {
  for (const std::uint32_t i : subset) add(frame, i);
}

void MatchArrays::add(const Frame& frame, std::size_t i) {
  const Match& match = frame.matches[i];
  points_.insert(points_.end(), match.point, match.point + 3);
  sigmas_.push_back(1 / std::sqrt(match.inv_sigma2));
  has_depth_cue_.push_back(match.has_depth_cue() ? 1 : 0);
  if (!frame.camera.rig.empty()) camera_ids_.push_back(match.camera_id);
  if (frame.map_covariances.empty()) return;
  map_covariances_.insert(map_covariances_.end(), frame.map_covariances[i].begin(), frame.map_covariances[i].end());
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

BlockReport build_blocks(const Frame& frame, const MatchArrays& matches, const BlockOptions& options,
                         BlockStore& blocks) {
  blocks.clear();
  const FrameCamera& camera = frame.camera;
  const RigidTransform T = RigidTransform::row_major(frame.T_cw_prior.data());
  if (camera.rig.empty()) return append_blocks(Camera(camera), T, matches.view(), options, blocks);
  return append_blocks(camera.rig.data(), camera.rig.size(), T, matches.view(), options, blocks);
}

BlockReport build_blocks(const Frame& frame, const BlockOptions& options, BlockStore& blocks) {
  return build_blocks(frame, MatchArrays(frame), options, blocks);
}

}  // namespace maxlogdet::sim
