// SPDX-License-Identifier: MIT
#pragma once

// What blocks have to be, from the position of a point in the camera frame, which a test computes by its tracker's own
// chain of transforms.

#include "bench/world/se3.hpp"
#include "tests/support/random_isometry.hpp"

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace maxlogdet::test {

/// A point in the camera frame and its covariance there, m and m^2; stereo baseline times focal length, px m (0:
/// monocular); focal lengths and the deviation of the measurement, px.
struct SeenPoint {
  Eigen::Vector3d p_c = Eigen::Vector3d::Zero();
  double bf = 0;
  double fx = 1;
  double fy = 1;
  double sigma = 1;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// H_x under exp(xi^) on the left of T_cw, and H_p with respect to the point in the camera frame, by central
/// differences of the projection to (u, v, u_right or Z).
struct Derivatives {
  explicit Derivatives(const SeenPoint& point);
  Eigen::Matrix<double, 3, 6> H_x;
  Eigen::Matrix3d H_p;
};

/// What a camera of any kind measures of a point, and the derivative of that under exp(xi^) on the left of the pose, by
/// central differences at p, the point in the frame that the pose leads to.
using Measure = std::function<Eigen::VectorXd(const Eigen::Vector3d& p)>;
Eigen::MatrixXd derivative_under_left_perturbation(const Measure& measure, const Eigen::Vector3d& p);

/// H_x^T (sigma^2 I + H_p Sigma_p H_p^T)^-1 H_x: `measurement` where the covariance is zero, else
/// `measurement_and_map`.
Matrix6 information_of(const SeenPoint& point);

/// Largest |entry| by which H^T H of stored blocks differs from `expected` of the points, in shares of the largest
/// entry.
double largest_difference(const BlockStore& blocks, const std::vector<SeenPoint>& points);

/// R x + t.
sim::Pose transform(const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

/// Up to some two metres and a radian and a half from the origin, so that no rotation is its own inverse.
sim::Pose random_pose(Random& random);

/// In front of a camera of some 90 degrees.
Eigen::Vector3d random_point_in_camera(Random& random);

}  // namespace maxlogdet::test
