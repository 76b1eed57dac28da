// SPDX-License-Identifier: MIT
#include "bench/world/match_noise.hpp"

#include <maxlogdet/eigen.hpp>
#include <maxlogdet/match_information.hpp>

#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// `map_covariance`: nullptr: none.
MatchNoise noise_of(const FrameCamera& camera, const Match& match, bool uses_depth_cue, const double* map_covariance) {
  MatchNoise noise;
  noise.sigma = 1 / std::sqrt(match.inv_sigma2);
  noise.covariance = map_covariance;
  if (camera.is_pinhole()) {
    if (uses_depth_cue && !(match.u_right < 0)) noise.depth_cue = DepthCue::stereo;
  } else if (uses_depth_cue && match.depth > 0) {
    noise.depth_cue = DepthCue::depth;
    noise.depth_sigma = camera.depth_sigma;
  }
  return noise;
}

}  // namespace

Eigen::Matrix3d Whitening::matrix() const {
  Eigen::Matrix3d W;
  W << w00, 0, 0, w10, w11, 0, w20, w21, w22;
  return W;
}

Whitening whitening_of(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
                       const Eigen::Matrix3d& map_covariance) {
  const bool is_exact = (map_covariance.array() == 0).all();
  const MatchNoise noise = noise_of(camera, match, uses_depth_cue, is_exact ? nullptr : map_covariance.data());
  const RigidTransform T(T_cw.matrix());
  double W[9];
  const Camera seen_by = camera.rig.empty() ? Camera(camera) : camera.rig[match.camera_id];
  const bool is_there = match_whitening(seen_by, T, match.point, noise, W);
  if (!is_there) return {nan, nan, nan, nan, nan, nan};
  if (noise.depth_cue == DepthCue::none) return {W[0], W[2], W[3], 0, 0, 0};
  return {W[0], W[3], W[4], W[6], W[7], W[8]};
}

Whitening measurement_whitening(const FrameCamera& camera, const Match& match) {
  const double variance = 1 / match.inv_sigma2;
  Whitening W;
  W.w00 = W.w11 = W.w22 = variance > 0 && std::isfinite(variance) ? 1 / std::sqrt(variance) : nan;
  if (!camera.is_pinhole()) W.w22 = match.depth > 0 ? 1 / camera.depth_sigma : 0;
  return W;
}

void whiten(const FrameCamera& camera, const Pose& T_cw, const std::vector<Match>& matches, bool uses_depth_cue,
            const double* map_covariances, double map_sigma, std::vector<Whitening>& whitenings) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity() * (map_sigma * map_sigma);
  whitenings.clear();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (map_covariances != nullptr) covariance = Eigen::Map<const Eigen::Matrix3d>(map_covariances + 9 * i);
    whitenings.push_back(whitening_of(camera, T_cw, matches[i], uses_depth_cue, covariance));
  }
}

}  // namespace maxlogdet::sim
