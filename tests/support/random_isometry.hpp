// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace maxlogdet::test {

inline Eigen::Vector3d random_vector(Random& random, double largest) {
  return {random.uniform(-largest, largest), random.uniform(-largest, largest), random.uniform(-largest, largest)};
}

/// Translation up to `metres` along each axis, rotation up to `radians` about any.
inline Eigen::Isometry3d random_isometry(Random& random, double metres, double radians) {
  Eigen::Isometry3d T(Eigen::AngleAxisd(random.uniform(-radians, radians), random_vector(random, 1).normalized()));
  T.translation() = random_vector(random, metres);
  return T;
}

}  // namespace maxlogdet::test
