// SPDX-License-Identifier: MIT
#pragma once

#include "sim/match_noise.hpp"
#include "tests/sim/precise_pose.hpp"
#include "tests/support/random_geometry.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

// Frames whose map points have covariances.

namespace maxlogdet::test {

using sim::Frame;

inline Pose pose_of(const Frame& frame) { return sim::pose_of(frame.T_cw_prior); }

// Exact matches of several octaves, some of them monocular, seen from a random pose.
inline Frame random_frame(Random& random, std::size_t n) {
  Frame frame;
  frame.camera = {450, 460, 376, 240, 50};
  const Pose T_cw = random_pose(random, 10, 1.5);
  frame.T_cw_prior = sim::to_rows(T_cw);
  for (std::size_t i = 0; i < n; ++i) {
    const double Z = random.uniform(2, 20);
    const Eigen::Vector3d p(Z * random.uniform(-0.4, 0.7), Z * random.uniform(-0.5, 0.5), Z);
    const Eigen::Vector3d in_world = T_cw.inverse() * p;
    Match match;
    std::copy_n(in_world.data(), 3, match.point);
    match.u = frame.camera.fx * p.x() / Z + frame.camera.cx;
    match.v = frame.camera.fy * p.y() / Z + frame.camera.cy;
    if (random.chance(0.7)) match.u_right = match.u - frame.camera.bf / Z;
    match.inv_sigma2 = std::pow(1.2, -2 * random.integer(0, 7));
    frame.matches.push_back(match);
  }
  return frame;
}

inline void set_covariance(Frame& frame, std::size_t i, const Eigen::Matrix3d& covariance) {
  frame.map_covariances.resize(frame.matches.size());
  std::copy_n(covariance.data(), 9, frame.map_covariances[i].begin());
}

inline Eigen::Matrix3d covariance_of(const Frame& frame, std::size_t i) {
  return Eigen::Map<const Eigen::Matrix3d>(frame.map_covariances[i].data());
}

inline std::vector<Whitening> whitenings_of(const Frame& frame, const Pose& T_cw, bool stereo, double map_sigma = 0) {
  std::vector<Whitening> whitenings;
  const double* const covariances = frame.map_covariances.empty() ? nullptr : frame.map_covariances.front().data();
  whiten(frame.camera, T_cw, frame.matches, stereo, covariances, map_sigma, whitenings);
  return whitenings;
}

inline Subset all_of(const Frame& frame) {
  Subset all(frame.matches.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

}  // namespace maxlogdet::test
