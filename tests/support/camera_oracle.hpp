// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/camera.hpp>

#include <Eigen/Geometry>
#include <cmath>

// Camera models a second time, in long double and apart from the library, derivatives by differences; and random
// cameras, poses, errors and points.

namespace maxlogdet::test {

using WideVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
using WideVector2 = Eigen::Matrix<long double, 2, 1>;
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

/// (u, v) of a point that has an image, as the model's paper writes it.
WideVector2 image_of(const Camera& camera, const WideVector3& p);

Camera random_camera(Random& random, CameraModel model);

/// Any of `camera_models`.
CameraModel random_model(Random& random);

WideVector3 random_direction(Random& random);
/// Up to 3 rad and 2 m.
WideIsometry random_isometry(Random& random);

/// Of what the camera sees, up to a right angle to its axis and more where its model can; often close to the axis.
WideVector3 random_point(Random& random, const Camera& camera);

/// Standard normal (Box & Muller 1958).
inline double normal(Random& random) {
  constexpr double pi = 3.14159265358979323846;
  return std::sqrt(-2 * std::log(random.uniform(1e-300, 1))) * std::cos(2 * pi * random.uniform(0, 1));
}

inline Eigen::Vector3d random_vector(Random& random, double largest) {
  return {random.uniform(-largest, largest), random.uniform(-largest, largest), random.uniform(-largest, largest)};
}

/// Translation up to `metres` along each axis, rotation up to `radians` about any.
inline Eigen::Isometry3d random_isometry(Random& random, double metres, double radians) {
  Eigen::Isometry3d T(Eigen::AngleAxisd(random.uniform(-radians, radians), random_vector(random, 1).normalized()));
  T.translation() = random_vector(random, metres);
  return T;
}

/// exp of a twist with uniform entries of up to `metres` and `radians`.
inline sim::Pose random_pose(Random& random, double metres, double radians) {
  sim::Vector6 xi;
  xi.head<3>() = random_vector(random, metres);
  xi.tail<3>() = random_vector(random, radians);
  return sim::exp_se3(xi);
}

/// A A^T + min_variance I, m^2, with uniform entries of A of up to `metres`.
inline Eigen::Matrix3d random_covariance(Random& random, double metres, double min_variance = 0) {
  Eigen::Matrix3d root;
  for (double& entry : root.reshaped()) entry = random.uniform(-metres, metres);
  return root * root.transpose() + min_variance * Eigen::Matrix3d::Identity();
}

}  // namespace maxlogdet::test
