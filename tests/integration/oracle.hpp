// SPDX-License-Identifier: MIT
#pragma once

// What blocks have to be, from the position of a point in the camera frame, which a test computes by its tracker's own
// chain of transforms.

#include "sim/se3.hpp"
#include "tests/support.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cstddef>
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
  explicit Derivatives(const SeenPoint& point) {
    const auto measure = [&](const Eigen::Vector3d& p) {
      const double u = point.fx * p.x() / p.z();
      return Eigen::Vector3d(u, point.fy * p.y() / p.z(), point.bf > 0 ? u - point.bf / p.z() : p.z());
    };
    constexpr double step = 1e-6;
    for (int i = 0; i < 6; ++i) {
      const sim::Vector6 xi = step * sim::Vector6::Unit(i);
      H_x.col(i) = (measure(sim::exp_se3(xi) * point.p_c) - measure(sim::exp_se3(-xi) * point.p_c)) / (2 * step);
    }
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(i);
      H_p.col(i) = (measure(point.p_c + d) - measure(point.p_c - d)) / (2 * step);
    }
  }
  Eigen::Matrix<double, 3, 6> H_x;
  Eigen::Matrix3d H_p;
};

/// The map_bias block.
inline Block map_bias_block(const SeenPoint& point) {
  const Derivatives derivatives(point);
  const Eigen::Matrix3d& H_p = derivatives.H_p;
  Eigen::Matrix<double, 3, 6> H_x = derivatives.H_x;
  if (point.bf > 0) return H_p.inverse() * H_x;
  H_x.row(2).setZero();  // the paper's H_x^n; the third row of H_p^n is that of the depth, (0, 0, 1)
  return (H_p.inverse() * H_x).topRows<2>();
}

/// H_x^T (sigma^2 I + H_p Sigma_p H_p^T)^-1 H_x: `measurement` where the covariance is zero, else
/// `measurement_and_map`.
inline Matrix6 information_of(const SeenPoint& point) {
  const Derivatives derivatives(point);
  const Eigen::Index rows = point.bf > 0 ? 3 : 2;
  const Eigen::MatrixXd H_x = derivatives.H_x.topRows(rows);
  const Eigen::MatrixXd H_p = derivatives.H_p.topRows(rows);
  const Eigen::MatrixXd noise =
      point.sigma * point.sigma * Eigen::MatrixXd::Identity(rows, rows) + H_p * point.covariance * H_p.transpose();
  return H_x.transpose() * noise.inverse() * H_x;
}

inline Matrix6 map_bias_information(const SeenPoint& point) {
  const Block H = map_bias_block(point);
  return H.transpose() * H;
}

/// Largest |entry| by which H^T H of stored blocks differs from `expected` of the points, in shares of the largest
/// entry.
inline double largest_difference(const BlockStore& blocks, const std::vector<SeenPoint>& points,
                                 Matrix6 (*expected_of)(const SeenPoint&) = information_of) {
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!blocks.is_valid(i)) return 1e300;
    const Block stored = stored_block(blocks, i);
    const Matrix6 expected = expected_of(points[i]);
    const Matrix6 difference = stored.transpose() * stored - expected;
    largest = std::max(largest, difference.cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff());
  }
  return largest;
}

inline Eigen::Vector3d random_vector(Random& random, double largest) {
  return {random.uniform(-largest, largest), random.uniform(-largest, largest), random.uniform(-largest, largest)};
}

/// Up to some two metres and a radian and a half from the origin, so that no rotation is its own inverse.
inline sim::Pose random_pose(Random& random) {
  sim::Vector6 xi;
  xi << random_vector(random, 2), random_vector(random, 0.9);
  return sim::exp_se3(xi);
}

/// In front of a camera of some 90 degrees.
inline Eigen::Vector3d random_point_in_camera(Random& random) {
  const double z = random.uniform(2, 20);
  return {random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z};
}

}  // namespace maxlogdet::test
