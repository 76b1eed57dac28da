// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Dense>

// To copy: priors for Options::prior from what trackers have. prior.data() has to live until select() returns.

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// From a Hessian of g2o's VertexSE3Expmap, of ORB-SLAM2 and 3: exp(xi^) T_cw, in the order (rotation, translation).
inline Matrix6 prior_of_g2o(const Matrix6& hessian) {
  Matrix6 prior;
  prior << hessian.bottomRightCorner<3, 3>(), hessian.bottomLeftCorner<3, 3>(),  //
      hessian.topRightCorner<3, 3>(), hessian.topLeftCorner<3, 3>();
  return prior;
}

// From the covariance of (position, rotation) of a body pose. R_cb, t_cb: body to camera; R_cw: world to camera.
// rotation_axes: R_cb for a rotation perturbed in the body (VINS-Fusion: Ps + delta p, Rs exp(delta theta^)), R_cw for
// one in the world.
inline Matrix6 prior_of_body_pose(const Matrix6& covariance, const Eigen::Vector3d& t_cb, const Eigen::Matrix3d& R_cw,
                                  const Eigen::Matrix3d& rotation_axes) {
  Eigen::Matrix3d t_cross;
  t_cross << 0, -t_cb.z(), t_cb.y(), t_cb.z(), 0, -t_cb.x(), -t_cb.y(), t_cb.x(), 0;
  Matrix6 A;  // xi = A (delta p, delta theta)
  A << -R_cw, -t_cross * rotation_axes, Eigen::Matrix3d::Zero(), -rotation_axes;
  return (A * covariance * A.transpose()).inverse();
}
