// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/linear_algebra.hpp"

namespace maxlogdet::test {

/// [I | -[p]x]: how a point in the frame that a pose leads to moves under exp(xi^) on the left of the pose.
inline WideMatrix pose_derivative(const Eigen::Matrix<long double, 3, 1>& p) {
  WideMatrix derivative(3, 6);
  derivative << 1, 0, 0, 0, p.z(), -p.y(), 0, 1, 0, -p.z(), 0, p.x(), 0, 0, 1, p.y(), -p.x(), 0;
  return derivative;
}

}  // namespace maxlogdet::test
