// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/match_noise.hpp"
#include "bench/world/se3.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

enum class PoseMethod {
  gauss_newton,         ///< eq. 3 of the paper, iterated
  levenberg_marquardt,  ///< damped; a step that raises the cost is rejected
};

struct PoseOptions {
  PoseMethod method = PoseMethod::levenberg_marquardt;
  bool stereo = true;            ///< use the right-image columns, or depths, of matches that have one
  double huber_monocular = 0;    ///< Huber threshold of |e| in deviations, for 2 rows; 0: squared error
  double huber_stereo = 0;       ///< the same for 3 rows
  int max_iterations = 10;       ///< linearisations from which a step was tried, rejected or not
  double step_tolerance = 1e-9;  ///< terminates when no entry of a step is larger, rad, and of translation over the
                                 ///< typical distance of the points; such a step is not taken
};

enum class PoseStatus {
  converged,
  iteration_limit,  ///< usable, although steps were still above the tolerance
  too_few_matches,  ///< fewer than 3 matches (6 rows) in front of the camera; T_cw is the start
  singular,  ///< the normal equations could not be solved, or a number was not finite; T_cw is the last good pose
};

const char* to_string(PoseStatus status);

struct PoseEstimate {
  Pose T_cw = Pose::Identity();
  PoseStatus status = PoseStatus::too_few_matches;
  int iterations = 0;
  double cost = 0;                        ///< 1/2 sum rho(e^T Sigma^-1 e) at T_cw
  Matrix6 information = Matrix6::Zero();  ///< H^T W H at T_cw

  bool is_usable() const { return status == PoseStatus::converged || status == PoseStatus::iteration_limit; }
  /// The covariance of the left perturbation: the inverse of `information`.
  Matrix6 covariance() const;
};

/// Returns the inverse of a symmetric positive definite matrix; NaN if it is singular up to rounding.
Matrix6 invert_information(const Matrix6& information);

/// Returns the squared error of a match in deviations: ||W e||^2 with the whitening W, or ||e||^2 inv_sigma2 without
/// one; infinite where the point is not in front of the camera, or a number is not finite.
double chi2(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
            const Whitening* whitening = nullptr);

/// Minimises the sum over the subset of rho(||W (z - h(T_cw, p))||^2) by steps T_cw <- exp(xi^) T_cw from `start`.
/// `subset`: indices into `matches`. `whitenings`: W, one for each of `matches`; empty: by the measurement's noise,
/// which is faster of a pinhole. They are constant while the pose moves, as the information matrix of an edge is in
/// g2o. Matches are left out while they are behind the camera, and always if a number is not finite or inv_sigma2 is
/// not positive. Levenberg-Marquardt takes no step that raises the cost of the matches that it was linearised with, or
/// moves one of them behind the camera.
PoseEstimate optimize_pose(const FrameCamera& camera, const std::vector<Match>& matches,
                           const std::vector<std::uint32_t>& subset, const Pose& start, const PoseOptions& options,
                           const std::vector<Whitening>& whitenings = {});

}  // namespace maxlogdet::sim
