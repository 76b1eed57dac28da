// SPDX-License-Identifier: MIT
#pragma once

// Derivatives by differences, in long double.

#include "tests/support/linear_algebra.hpp"

#include <Eigen/Geometry>

namespace maxlogdet::test {

using WideVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
using WideVector3 = Eigen::Matrix<long double, 3, 1>;
using WideIsometry = Eigen::Transform<long double, 3, Eigen::Isometry>;

/// Central differences of f at 0 along each of its coordinates.
template <class Function>
WideMatrix differentiate(int dimension, const Function& f) {
  constexpr long double h = 1e-6L;  // error h^2 = 1e-12 of the third derivative
  WideMatrix jacobian;
  for (int i = 0; i < dimension; ++i) {
    WideVector step = WideVector::Zero(dimension);
    step(i) = h;
    const WideVector difference = (f(step) - f(-step)) / (2 * h);
    jacobian.conservativeResize(difference.size(), dimension);
    jacobian.col(i) = difference;
  }
  return jacobian;
}

/// exp(xi^), xi = (translation, rotation), for an xi of one entry, so that it is a translation or a rotation.
inline WideIsometry exp_of_one(const WideVector& xi) {
  WideIsometry step = WideIsometry::Identity();
  step.translation() = xi.head<3>();
  const WideVector3 rotation = xi.tail<3>();
  if (rotation.norm() > 0) step.rotate(Eigen::AngleAxis<long double>(rotation.norm(), rotation.normalized()));
  return step;
}

}  // namespace maxlogdet::test
