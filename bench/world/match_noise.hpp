// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>
#include <vector>

namespace maxlogdet::sim {

/// W = L^-1 with Sigma = L L^T, lower triangular: W times a match's residual e = z - h(T_cw, p) has independent entries
/// of variance 1. 2 or 3 rows; with 2 the third is zero. W^T W is what g2o calls an edge's information matrix.
struct Whitening {
  double w00 = 1, w10 = 0, w11 = 1, w20 = 0, w21 = 0, w22 = 1;

  void apply(double& e0, double& e1, double& e2) const {
    e2 = w20 * e0 + w21 * e1 + w22 * e2;
    e1 = w10 * e0 + w11 * e1;
    e0 = w00 * e0;
  }

  Eigen::Matrix3d matrix() const;
};

/// Whitens by the library's match_whitening(), as blocks of Weighting::measurement_and_map are: `map_covariance` is
/// Sigma_p, 3 x 3, world frame, m^2, or zero. With `uses_depth_cue`, matches that have a third measurement have three
/// rows. Not finite where there is none (the point is not in front of the camera, 1 / inv_sigma2 not positive and
/// finite, Sigma not positive definite or without digits): chi2() is infinite then, and optimize_pose() leaves the
/// match out.
Whitening whitening_of(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
                       const Eigen::Matrix3d& map_covariance);

/// Whitens by Sigma_z alone.
Whitening measurement_whitening(const FrameCamera& camera, const Match& match);

/// Whitens all matches. `map_covariances`: 9 numbers for each match; nullptr: map_sigma^2 I for all.
void whiten(const FrameCamera& camera, const Pose& T_cw, const std::vector<Match>& matches, bool uses_depth_cue,
            const double* map_covariances, double map_sigma, std::vector<Whitening>& whitenings);

}  // namespace maxlogdet::sim
