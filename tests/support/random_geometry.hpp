// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Core>
#include <cmath>

// Random poses and errors.
namespace maxlogdet::test {

/// Standard normal (Box & Muller 1958).
inline double normal(Random& random) {
  constexpr double pi = 3.14159265358979323846;
  return std::sqrt(-2 * std::log(random.uniform(1e-300, 1))) * std::cos(2 * pi * random.uniform(0, 1));
}

/// exp of a twist with uniform entries of up to `metres` and `radians`.
inline sim::Pose random_pose(Random& random, double metres, double radians) {
  sim::Vector6 xi;
  for (int i = 0; i < 3; ++i) {
    xi(i) = random.uniform(-metres, metres);
    xi(i + 3) = random.uniform(-radians, radians);
  }
  return sim::exp_se3(xi);
}

/// A A^T + min_variance I, m^2, with uniform entries of A of up to `metres`.
inline Eigen::Matrix3d random_covariance(Random& random, double metres, double min_variance = 0) {
  Eigen::Matrix3d root;
  for (double& entry : root.reshaped()) entry = random.uniform(-metres, metres);
  return root * root.transpose() + min_variance * Eigen::Matrix3d::Identity();
}

}  // namespace maxlogdet::test
