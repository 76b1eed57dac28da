// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/status.hpp>
#include <maxlogdet/weighting.hpp>

#include <cstddef>

// From matches to blocks. World points p_w, pose T_cw = [R | t] (world to camera), p_c = R p_w + t = (X, Y, Z), camera
// frame x right, y down, z forward, m. Any other unit of length serves as well, if all lengths have it: points, poses,
// depths, bf, and the deviations and limits of BlockOptions and Options. The measurement z is (u, v), px, as the camera
// projects p_c (camera.hpp), and optionally one row more:
//
//   u_right = u - bf / Z + shift_of_right  (stereo, of a pinhole)   or   depth = Z  (m).
//
// The pose is perturbed on the left, T_cw <- exp(xi^) T_cw, xi = (translation, rotation) in m and rad, so that
//
//   H_x = d z / d xi  = J [ I | -[p_c]x ]      rows x 6,
//   H_p = d z / d p_w = J R                    rows x 3,     with J = d z / d p_c.
//
// Of a camera with a pose T_cb on a body, the pose is that of the body, T_bw, p_b = T_bw p_w, p_c = T_cb p_b, and H_x =
// J R_cb [ I | -[p_b]x ]. There, p_b replaces the p_c of a block's form, but map_bias uses the camera's own p_c.
//
// With `measurement` and `measurement_and_map` the rows of a block are those of the whitened measurements up to a
// rotation Q, which changes no information H^T H: H = A [ I | -[p_c]x ] with an upper triangular A. With a stereo row
// they are for example those of ((u + u_right) / sqrt(2), v, (u_right - u) / sqrt(2)).
//
// A prior for these blocks is an information of this xi, in this order and in the units of the blocks: with
// `measurement` and `measurement_and_map` H^T H is an information in the statistical sense, with `map_bias` only up to
// the variance of the map error.
//
// docs/guide.md tells which weighting to use.

namespace maxlogdet {

/// All weightings, in their order.
constexpr Weighting weightings[] = {Weighting::map_bias, Weighting::map_bias_world, Weighting::measurement,
                                    Weighting::measurement_and_map};

/// The weighting to use when the covariances of the points are known: measurement_and_map for `measurement`, every
/// other one itself.
constexpr Weighting with_covariances(Weighting weighting) noexcept {
  return weighting == Weighting::measurement ? Weighting::measurement_and_map : weighting;
}

/// n matches as arrays of the caller, neither copied nor kept. A null optional array means its default for all matches.
struct Matches {
  std::size_t size = 0;            ///< n
  Points points;                   ///< n: p_w, m, float or double, with any stride
  const double* sigmas = nullptr;  ///< n: sigma, px: scale_factor^octave times the base standard deviation; default 1
  const unsigned char* has_depth_cue = nullptr;  ///< n: nonzero where a depth cue is measured; default: all have it
  const unsigned char* usable = nullptr;         ///< n: zero keeps a match as an invalid candidate (an empty slot, an
                                                 ///< outlier); default: all are usable
  const double* map_covariances = nullptr;    ///< n x 3 x 3: Sigma_p, world frame, m^2, symmetric positive semidefinite
                                              ///< (the upper triangle is read, row-major); default
                                              ///< BlockOptions::map_sigma^2 I (measurement_and_map only)
  const unsigned char* camera_ids = nullptr;  ///< n: index of the camera that has seen the match; default 0
};

/// How blocks are made of matches.
struct BlockOptions {
  Weighting weighting = Weighting::measurement;  ///< which block
  DepthCue depth_cue = DepthCue::none;           ///< which third row
  double map_sigma = 0.05;                       ///< m, standard deviation of a map point (measurement_and_map)
  double depth_sigma = 0.05;                     ///< m, standard deviation of a depth measurement
  double min_depth = 0;  ///< m: a nearer match is no candidate. Z for models that end in front of the camera
                         ///< (pinhole, radial_tangential), else |p_c|; 0: none is too near
};

/// The result of append_blocks.
struct BlockReport {
  Error error = Error::none;            ///< none, or why nothing was appended
  std::size_t appended = 0;             ///< n, or 0 after an error
  std::size_t invalid = 0;              ///< of these, the invalid candidates, for whatever reason
  std::size_t unusable = 0;             ///< matches with Matches::usable 0
  std::size_t behind_camera = 0;        ///< Z <= 0, or where the camera's model has no image
  std::size_t too_near = 0;             ///< in front of the camera, nearer than min_depth
  std::size_t singular_rays = 0;        ///< |cos(ray, world z)| < 1e-6 (map_bias_world, monocular)
  std::size_t invalid_covariances = 0;  ///< Sigma not positive definite, or Sigma_p so large along the ray that float64
                                        ///< keeps no digits across it (docs/numerics.md)
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Weighting weighting) noexcept;

/// Appends one block per match, in their order; a match without one (BlockReport tells why) becomes an invalid
/// candidate. Allocates only when the capacity of the blocks does not suffice. T_cw: world to camera; of a camera whose
/// T_cb is not I, world to body.
BlockReport append_blocks(const Camera& camera, const RigidTransform& T_cw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks);

/// The same on a rig, 1 to 256 cameras on one body: the blocks are about the pose T_bw, world to body, and
/// Matches::camera_ids says which camera has seen each match. Options::groups can give each camera its share.
BlockReport append_blocks(const Camera* cameras, std::size_t count, const RigidTransform& T_bw, const Matches& matches,
                          const BlockOptions& options, BlockStore& blocks);

}  // namespace maxlogdet
