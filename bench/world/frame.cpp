// SPDX-License-Identifier: MIT
#include "bench/world/frame.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::sim {

DepthCue FrameCamera::depth_cue() const noexcept {
  if (depth_sigma > 0) return DepthCue::depth;
  return rig.empty() && bf > 0 ? DepthCue::stereo : DepthCue::none;
}

FeatureMatch feature_match(const Match& match, DepthCue depth_cue) {
  const double uv[2] = {match.u, match.v};
  FeatureMatch made(match.point, uv, 1 / std::sqrt(match.inv_sigma2));
  if (depth_cue == DepthCue::stereo) made.u_right = match.u_right;
  if (depth_cue == DepthCue::depth) made.depth = match.depth;
  made.camera_id = match.camera_id;
  return made;
}

std::vector<FeatureMatch> feature_matches(const Frame& frame, DepthCue depth_cue) {
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    matches.push_back(feature_match(frame.matches[i], depth_cue));
    const double* const covariance = frame.map_covariances.empty() ? nullptr : frame.map_covariances[i].data();
    if (covariance != nullptr && !std::isnan(*covariance)) matches[i].covariance = covariance;
  }
  return matches;
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

BlockReport build_blocks(const Frame& frame, const std::vector<FeatureMatch>& matches, const BlockOptions& options,
                         BlockStore& blocks) {
  blocks.clear();
  const FrameCamera& camera = frame.camera;
  const RigidTransform T = RigidTransform::row_major(frame.T_cw_prior.data());
  const Camera alone(camera);
  const Camera* const cameras = camera.rig.empty() ? &alone : camera.rig.data();
  const std::size_t count = camera.rig.empty() ? 1 : camera.rig.size();
  return append_blocks(cameras, count, T, matches.data(), matches.size(), options, blocks);
}

}  // namespace maxlogdet::sim
