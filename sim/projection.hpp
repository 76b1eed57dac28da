// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"
#include "sim/se3.hpp"

#include <Eigen/Core>

namespace maxlogdet::sim {

/// A match linearised at a pose, as maxlogdet/jacobian.hpp defines it: left perturbation, (translation, rotation), px.
/// Rows beyond `rows` are zero.
struct LinearizedMatch {
  int rows = 0;              ///< 2 monocular, 3 stereo
  Eigen::Vector3d residual;  ///< z - h(x, p)
  Eigen::Matrix<double, 3, 6> H_x;
  Eigen::Matrix3d H_p;  ///< with respect to the point in the world frame
};

/// Linearises `match` at T_cw; its right-image column counts if `stereo`. Returns false where the point is not in front
/// of the camera (Z <= 0), or a number is not finite.
bool linearize(const PinholeCamera& camera, const Pose& T_cw, const Match& match, bool stereo, LinearizedMatch& result);

}  // namespace maxlogdet::sim
