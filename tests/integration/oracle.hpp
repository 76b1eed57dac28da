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

/// A point in the camera frame, m, and the stereo baseline times the focal length, px m; 0: monocular.
struct SeenPoint {
  Eigen::Vector3d p_c = Eigen::Vector3d::Zero();
  double bf = 0;
};

/// The map_bias block by central differences of the projection under exp(xi^) on the left of T_cw.
inline Block map_bias_block(const SeenPoint& point) {
  const auto measure = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x() / p.z(), p.y() / p.z(), point.bf > 0 ? p.x() / p.z() - point.bf / p.z() : p.z());
  };
  constexpr double step = 1e-6;
  Eigen::Matrix<double, 3, 6> H_x;
  for (int i = 0; i < 6; ++i) {
    const sim::Vector6 xi = step * sim::Vector6::Unit(i);
    H_x.col(i) = (measure(sim::exp_se3(xi) * point.p_c) - measure(sim::exp_se3(-xi) * point.p_c)) / (2 * step);
  }
  Eigen::Matrix3d H_p;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(i);
    H_p.col(i) = (measure(point.p_c + d) - measure(point.p_c - d)) / (2 * step);
  }
  if (point.bf > 0) return H_p.inverse() * H_x;
  H_x.row(2).setZero();  // the paper's H_x^n; the third row of H_p^n is that of the depth, (0, 0, 1)
  return (H_p.inverse() * H_x).topRows<2>();
}

/// Largest |entry| by which stored blocks differ from those of the points, in shares of the largest of the block.
inline double largest_difference(const BlockStore& blocks, const std::vector<SeenPoint>& points) {
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!blocks.is_valid(i)) return 1e300;
    const Block stored = stored_block(blocks, i);
    const Block rows = map_bias_block(points[i]);
    if (stored.rows() < rows.rows()) return 1e300;
    Block expected = Block::Zero(stored.rows(), 6);
    expected.topRows(rows.rows()) = rows;
    largest = std::max(largest, (stored - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff());
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
