// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/pose_optimizer.hpp"
#include "bench/world/se3.hpp"

#include <limits>

namespace maxlogdet::sim {

/// The error of an estimated pose; NaN without a usable estimate.
struct PoseError {
  double translation_m = 0;  ///< of the camera's centre
  double rotation_deg = 0;
};

inline PoseError pose_error(const PoseEstimate& estimate, const Pose& true_T_cw) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (!estimate.is_usable()) return {nan, nan};
  return {camera_distance(estimate.T_cw, true_T_cw), camera_angle_deg(estimate.T_cw, true_T_cw)};
}

}  // namespace maxlogdet::sim
