// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/status.hpp>

#include <cstddef>

// From matches to blocks. World points p_w, pose T_cw = [R | t] (world to camera), p_c = R p_w + t = (X, Y, Z), camera
// frame x right, y down, z forward, m. Any other unit of length serves as well, if all lengths have it: points, poses,
// depths, bf, and the deviations of BlockOptions and Options. The measurement z is (u, v), px, as the camera projects
// p_c (camera.hpp), and optionally one row more:
//
//   u_right = u - bf / Z + shift_of_right  (stereo, of a pinhole)   or   depth = Z  (m).
//
// The pose is perturbed on the left, T_cw <- exp(xi^) T_cw, xi = (translation, rotation) in m and rad, so that
//
//   H_x = d z / d xi  = J [ I | -[p_c]x ]      rows x 6,
//   H_p = d z / d p_w = J R                    rows x 3,     with J = d z / d p_c.
//
// The noise of z is Sigma = Sigma_z + H_p Sigma_p H_p^T: Sigma_z is that of the measurement, sigma^2 for u, v and
// u_right, and depth_sigma^2; Sigma_p, the covariance of the point, counts if any match of the frame has one. A block
// is C^-1 H_x with C C^T = Sigma, so that the sum of H^T H is the information of the pose, where points are held fixed.
//
// Of a camera with a pose T_cb on a body, the pose is that of the body, T_bw, p_b = T_bw p_w, p_c = T_cb p_b, and H_x =
// J R_cb [ I | -[p_b]x ].
//
// The rows of a block are those of the whitened measurements up to a rotation Q, which changes no information H^T H:
// H = A [ I | -[p_c]x ] with an upper triangular A. With a stereo row they are for example those of ((u + u_right) /
// sqrt(2), v, (u_right - u) / sqrt(2)).
//
// A prior for these blocks is an information of this xi, in this order and in the units of the blocks.

namespace maxlogdet {

/// How blocks are made of matches.
struct BlockOptions {
  double map_sigma = 0.05;    ///< m, standard deviation of a point without covariance, where other matches have one
  double depth_sigma = 0.05;  ///< m, standard deviation of a depth measurement
};

/// The result of append_blocks.
struct BlockReport {
  Error error = Error::none;            ///< none, or why nothing was appended
  std::size_t appended = 0;             ///< the number of matches, or 0 after an error
  std::size_t invalid = 0;              ///< of these, the invalid candidates, for whatever reason
  std::size_t unusable = 0;             ///< matches of a camera that is not there; of GoodFeatures also rejected ones
  std::size_t behind_camera = 0;        ///< Z <= 0, or where the camera's model has no image
  std::size_t invalid_covariances = 0;  ///< Sigma not positive definite, or Sigma_p so large along the ray that float64
                                        ///< keeps no digits across it (docs/numerics.md)
};

/// Appends one block for each of `size` matches, in their order; a match without one (BlockReport tells why) becomes an
/// invalid candidate. Allocates only when the capacity of the blocks does not suffice. T_cw: world to camera; of a
/// camera whose T_cb is not I, world to body.
BlockReport append_blocks(const Camera& camera, const RigidTransform& T_cw, const FeatureMatch* matches,
                          std::size_t size, const BlockOptions& options, BlockStore& blocks);

/// The same on a rig, 1 to 256 cameras on one body: the blocks are about the pose T_bw, world to body, and
/// FeatureMatch::camera_id says which camera has seen each match.
BlockReport append_blocks(const Camera* cameras, std::size_t count, const RigidTransform& T_bw,
                          const FeatureMatch* matches, std::size_t size, const BlockOptions& options,
                          BlockStore& blocks);

}  // namespace maxlogdet
