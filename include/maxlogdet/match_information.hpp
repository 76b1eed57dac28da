// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>

#include <cstddef>

// The weight of a match in a pose optimiser that holds the map points fixed, from the noise model of the blocks: with
// the residual e = z - h(T_cw, p_w), z = (u, v) or (u, v, cue), where cue is u_right or a depth,
//
//   Sigma = Sigma_z + J Sigma_p J^T,   J = d h / d p_w at T_cw,   Sigma_z = diag(sigma^2, sigma^2, that of the cue),
//
// where Sigma_p is the covariance of the point. Omega = Sigma^-1 is g2o's information matrix of an edge; W = L^-1,
// Sigma = L L^T, is what Ceres calls its square root: W e has independent entries of variance 1, and W^T W = Omega.
// H_x^T Omega H_x is the H^T H of the match's block with Weighting::measurement_and_map.
//
// Compute weights once, at the pose that optimisation starts from and the blocks are made at, and keep them while the
// pose moves. If Sigma followed the pose, the optimiser could lower its cost by moving to where Sigma is large. The
// weights are for points that are held fixed: where points are estimated together with poses (bundle adjustment,
// filters), their errors are part of the problem already, and would be counted twice.
//
//   maxlogdet::MatchNoise noise;
//   noise.sigma = sigma_of_octave;
//   noise.covariance = covariance;  // of PointCovariance, say
//   noise.depth_cue = has_right ? DepthCue::stereo : DepthCue::none;
//   if (match_information(camera, T_cw, p_w, noise, omega)) edge->setInformation(Eigen::Map<...>(omega));

namespace maxlogdet {

/// The noise of a match's residual.
struct MatchNoise {
  double sigma = 1;                     ///< standard deviation of u, v and u_right, px
  const double* covariance = nullptr;   ///< Sigma_p, 3 x 3, world frame, m^2, symmetric positive
                                        ///< semidefinite (the upper triangle is read, row-major)
  double map_sigma = 0;                 ///< m: without a covariance Sigma_p is map_sigma^2 I; 0: none
  DepthCue depth_cue = DepthCue::none;  ///< what this match has measured besides u and v
  double depth_sigma = 0.05;            ///< standard deviation of a depth, m
};

/// The number of rows of a residual: 2, or 3 with a depth cue.
constexpr std::size_t residual_rows(DepthCue cue) noexcept { return cue == DepthCue::none ? 2 : 3; }

/// The noise of match i as append_blocks assumes it: Sigma_p counts only with Weighting::measurement_and_map. It points
/// into the arrays of the matches.
MatchNoise match_noise(const Matches& matches, std::size_t i, const BlockOptions& options) noexcept;

/// Writes Omega, px^-2 (m^-1 for each index of a depth): r x r row-major, r = residual_rows(noise.depth_cue), in the
/// order u, v, cue. p_w: 3 entries, m. Returns false, and writes nothing, just where append_blocks of a camera alone
/// would refuse the camera or make no block for a reason of this noise; an optimiser then uses I / sigma^2.
bool match_information(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                       double* omega) noexcept;

/// Writes W, r x r row-major, lower triangular with zeros above; otherwise as match_information.
bool match_whitening(const Camera& camera, const RigidTransform& T_cw, const double* p_w, const MatchNoise& noise,
                     double* W) noexcept;

}  // namespace maxlogdet
