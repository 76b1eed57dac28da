// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>

namespace maxlogdet::sim {

/// A match linearised at a pose, as maxlogdet/block_store.hpp defines it: left perturbation, (translation, rotation),
/// px; a row of depth is in m. Rows beyond `rows` are zero.
struct LinearizedMatch {
  int rows = 0;              ///< 2 monocular, 3 with a right-image column or a depth
  Eigen::Vector3d residual;  ///< z - h(x, p)
  Eigen::Vector3d p;         ///< the point in the frame of T_cw
  Eigen::Matrix3d J;         ///< d h / d p

  /// [J | -J [p]x].
  Eigen::Matrix<double, 3, 6> H_x() const;
  /// With respect to the point in the world frame.
  Eigen::Matrix3d H_p(const Pose& T_cw) const { return J * T_cw.linear(); }
};

/// Linearises `match` at T_cw, of a rig the pose of its body; its third measurement counts if `uses_depth_cue`. Returns
/// false where the camera has no image of the point (of a pinhole Z <= 0), or a number is not finite.
bool linearize(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
               LinearizedMatch& result);

/// Appends the block of the paper's section II, H_c = H_p^n^-1 H_x^n with the point p in the frame of a pinhole, by u
/// and v: [I - p e_3^T / Z] [I | -[p]x], m per unit of xi, of which the third row is zero. All errors are those of the
/// map, and alike in m. A point that is not in front of the camera becomes an invalid candidate.
void append_paper_block(const Pose& T_cw, const Match& match, BlockStore& blocks);

}  // namespace maxlogdet::sim
