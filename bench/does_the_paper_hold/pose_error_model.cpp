// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pose_error_model.hpp"

#include "bench/does_the_paper_hold/eigenvalues.hpp"
#include "bench/world/pose_optimizer.hpp"
#include "bench/world/projection.hpp"

#include <Eigen/LU>
#include <limits>

namespace maxlogdet::sim {
namespace {

// H_x^T (H_p H_p^T)^-1 H_x of the first `rows` rows: monocular ones have a third row of zeros, which has no inverse.
template <int rows>
Matrix6 weighted_by_map(const LinearizedMatch& match) {
  const Eigen::Matrix<double, rows, 6> H_x = match.H_x.topRows<rows>();
  const Eigen::Matrix<double, rows, 3> H_p = match.H_p.topRows<rows>();
  const Eigen::Matrix<double, rows, rows> spread = H_p * H_p.transpose();
  return H_x.transpose() * spread.inverse() * H_x;
}

}  // namespace

PoseErrorModel::PoseErrorModel(const PinholeCamera& camera, const std::vector<Match>& matches,
                               const std::vector<std::uint32_t>& subset, const Pose& T_cw, bool stereo)
    : H_xT_H_p_H_pT_H_x_(Matrix6::Zero()),
      weighted_information_(Matrix6::Zero()),
      H_xT_H_p_1_(Eigen::Matrix<double, 6, 3>::Zero()) {
  Matrix6 information = Matrix6::Zero();
  for (const std::uint32_t i : subset) {
    LinearizedMatch match;
    if (!linearize(camera, T_cw, matches[i], stereo, match)) continue;
    const Eigen::Matrix<double, 6, 3> H_xT_H_p = match.H_x.transpose() * match.H_p;
    information += match.H_x.transpose() * match.H_x;
    H_xT_H_p_H_pT_H_x_ += H_xT_H_p * H_xT_H_p.transpose();
    H_xT_H_p_1_ += H_xT_H_p;
    weighted_information_ += match.rows == 3 ? weighted_by_map<3>(match) : weighted_by_map<2>(match);
  }
  inverse_information_ = invert_information(information);
}

Matrix6 PoseErrorModel::covariance_of_measurement_error(double sigma_z) const {
  return sigma_z * sigma_z * inverse_information_;
}

Matrix6 PoseErrorModel::covariance_of_map_error(double sigma_p) const {
  return sigma_p * sigma_p * inverse_information_ * H_xT_H_p_H_pT_H_x_ * inverse_information_;
}

Matrix6 PoseErrorModel::covariance_of_map_error_weighted(double sigma_p) const {
  return sigma_p * sigma_p * invert_information(weighted_information_);
}

Vector6 PoseErrorModel::expected_error(const Eigen::Vector3d& mu_p) const {
  return -inverse_information_ * H_xT_H_p_1_ * mu_p;
}

Vector6 PoseErrorModel::bias_amplification() const {
  const Matrix6 squared = covariance_of_map_error(1);  // H_x^+ H_p (H_x^+ H_p)^T
  if (!squared.allFinite()) return Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  return eigenvalues_of(squared).reverse().cwiseMax(0).cwiseSqrt();  // a zero may round to a negative number
}

}  // namespace maxlogdet::sim
