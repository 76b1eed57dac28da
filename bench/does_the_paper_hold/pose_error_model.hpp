// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// Section II of the paper: how errors of measurements and of the map propagate to a least-squares pose,
/// eps_x = H_x^+ (eps_z - H_p eps_p) (eq. 4), for the left perturbation, with equal weights as in the paper.
class PoseErrorModel {
 public:
  /// Linearises the matches of `subset` in front of the camera; unless H_x has rank 6, no answer is finite.
  PoseErrorModel(const PinholeCamera& camera, const std::vector<Match>& matches,
                 const std::vector<std::uint32_t>& subset, const Pose& T_cw, bool stereo);

  /// Eq. 5: sigma_z^2 (H_x^T H_x)^-1; sigma_z in px.
  Matrix6 covariance_of_measurement_error(double sigma_z) const;

  /// Eq. 6, first line: sigma_p^2 H_x^+ H_p H_p^T H_x^+^T; sigma_p in m. This is the covariance of the pose that
  /// ordinary least squares gives.
  Matrix6 covariance_of_map_error(double sigma_p) const;

  /// Eq. 6, second line: sigma_p^2 (sum H_x(i)^T (H_p(i) H_p(i)^T)^-1 H_x(i))^-1. The paper sets both lines equal; this
  /// one belongs to least squares weighted by (H_p H_p^T)^-1, and is never larger (Gauss-Markov).
  Matrix6 covariance_of_map_error_weighted(double sigma_p) const;

  /// Eq. 7 with the sign of eq. 4: E[eps_x] = -H_x^+ H_p 1_n mu_p; mu_p in m, world frame.
  Vector6 expected_error(const Eigen::Vector3d& mu_p) const;

  /// Singular values of H_x^+ H_p, largest first: the largest is the paper's worst case of bias amplification.
  Vector6 bias_amplification() const;

 private:
  Matrix6 inverse_information_;             // (H_x^T H_x)^-1
  Matrix6 H_xT_H_p_H_pT_H_x_;               // H_x^T H_p H_p^T H_x
  Matrix6 weighted_information_;            // sum H_x(i)^T (H_p(i) H_p(i)^T)^-1 H_x(i)
  Eigen::Matrix<double, 6, 3> H_xT_H_p_1_;  // H_x^T H_p 1_n
};

}  // namespace maxlogdet::sim
