// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// W = L^-1 with Sigma = L L^T, lower triangular: W times a match's residual e = z - h(T_cw, p) has independent entries
/// of variance 1. 2 or 3 rows; with 2 the third is zero. W^T W is what g2o calls an edge's information matrix.
using Whitening = Eigen::Matrix3d;

/// Whitens by Sigma_z alone.
Whitening measurement_whitening(const FrameCamera& camera, const Match& match);

/// Whitens by Sigma = Sigma_z + H_p Sigma_p H_p^T at T_cw. `map_covariance` is Sigma_p, 3 x 3, world frame, m^2. With
/// `uses_depth_cue`, matches that have a third measurement have three rows. Not finite where there is none (the camera
/// has no image of the point, 1 / inv_sigma2 is not positive and finite, Sigma not positive definite): chi2() is
/// infinite then, and optimize_pose() leaves the match out.
Whitening whitening_of(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
                       const Eigen::Matrix3d& map_covariance);

/// Whitens all matches of a frame at T_cw, as the blocks of the library are: by Sigma_z alone if the frame has no
/// covariances; if it has, the covariance of a point of which it is unknown is map_sigma^2 I.
std::vector<Whitening> whitenings_of(const Frame& frame, const Pose& T_cw, bool uses_depth_cue, double map_sigma);

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

struct PoseEstimate {
  Pose T_cw = Pose::Identity();
  PoseStatus status = PoseStatus::too_few_matches;
  int iterations = 0;
  double cost = 0;                        ///< 1/2 sum rho(e^T Sigma^-1 e) at T_cw
  Matrix6 information = Matrix6::Zero();  ///< H^T W H at T_cw

  bool is_usable() const { return status == PoseStatus::converged || status == PoseStatus::iteration_limit; }
  /// The covariance of the left perturbation: the inverse of `information`; NaN if it is singular up to rounding.
  Matrix6 covariance() const;
};

/// Returns the squared error of a match in deviations, ||W e||^2; `whitening`: W, nullptr: by the measurement's noise.
/// Infinite where the point is not in front of the camera, or a number is not finite.
double chi2(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
            const Whitening* whitening = nullptr);

/// Minimises the sum over the subset of rho(||W (z - h(T_cw, p))||^2) by steps T_cw <- exp(xi^) T_cw from `start`.
/// `subset`: indices into `matches`. `whitenings`: W, one for each of `matches`; empty: by the measurement's noise.
/// They are constant while the pose moves, as the information matrix of an edge is in g2o. Matches are left out while
/// they are behind the camera, and always if a number is not finite or inv_sigma2 is not positive. Levenberg-Marquardt
/// takes no step that raises the cost of the matches that it was linearised with, or moves one of them behind the
/// camera.
PoseEstimate optimize_pose(const FrameCamera& camera, const std::vector<Match>& matches,
                           const std::vector<std::uint32_t>& subset, const Pose& start, const PoseOptions& options,
                           const std::vector<Whitening>& whitenings = {});

/// ORB-SLAM2's pose optimisation (Mur-Artal & Tardos 2017): every round restarts at the same pose with the inliers of
/// the round before; then the chi2 of every match decides again. The last round is without the Huber loss.
struct RejectionOptions {
  int rounds = 4;
  int max_iterations = 10;        ///< in a round
  double chi2_monocular = 5.991;  ///< 95 % quantile with 2 degrees of freedom; its root is the Huber threshold
  double chi2_stereo = 7.815;     ///< the same with 3
  bool stereo = true;
  double step_tolerance = 1e-9;
};

struct Rejection {
  PoseEstimate estimate;
  std::vector<std::uint32_t> inliers;  ///< ascending
};

/// Estimates the pose from the matches of `subset`, and which of them agree with it: their chi2 is within the limit for
/// their rows. A round without a usable estimate is the last: the inliers are then the matches that it was estimated
/// from. `whitenings` as in optimize_pose().
Rejection reject_outliers(const FrameCamera& camera, const std::vector<Match>& matches,
                          const std::vector<std::uint32_t>& subset, const Pose& start, const RejectionOptions& options,
                          const std::vector<Whitening>& whitenings = {});

}  // namespace maxlogdet::sim
