// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/match_noise.hpp"
#include "tests/bench/precise_pose.hpp"
#include "tests/bench/simulated_frames.hpp"

#include <algorithm>
#include <vector>

// Frames whose map points have covariances.

namespace maxlogdet::test {

inline Pose pose_of(const Frame& frame) { return sim::pose_of(frame.T_cw_prior); }

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

}  // namespace maxlogdet::test
