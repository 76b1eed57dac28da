// SPDX-License-Identifier: MIT
#pragma once

#include "sim/se3.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Core>
#include <cmath>

// What tests draw of poses and errors.
namespace maxlogdet::test {

/// Standard normal (Box & Muller 1958).
inline double normal(Random& random) {
  constexpr double pi = 3.14159265358979323846;
  return std::sqrt(-2 * std::log(random.uniform(1e-300, 1))) * std::cos(2 * pi * random.uniform(0, 1));
}

/// exp of a twist whose entries are uniform: up to so many m, and rad.
inline sim::Pose random_pose(Random& random, double metres, double radians) {
  sim::Vector6 xi;
  for (int i = 0; i < 3; ++i) {
    xi(i) = random.uniform(-metres, metres);
    xi(i + 3) = random.uniform(-radians, radians);
  }
  return sim::exp_se3(xi);
}

/// A A^T + least I, m^2, the entries of A uniform: up to so many m.
inline Eigen::Matrix3d random_covariance(Random& random, double metres, double least = 0) {
  Eigen::Matrix3d root;
  for (double& entry : root.reshaped()) entry = random.uniform(-metres, metres);
  return root * root.transpose() + least * Eigen::Matrix3d::Identity();
}

}  // namespace maxlogdet::test
