// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/trajectory_error.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace maxlogdet::test {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Poses = std::vector<sim::StampedPose>;

inline Vector3d random_vector(Random& random, double scale = 1) {
  Vector3d v;
  for (double& entry : v) entry = scale * random.uniform(-1, 1);  // in this order, unlike arguments of a call
  return v;
}

inline Eigen::Quaterniond random_rotation(Random& random) {
  Eigen::Vector4d q(0, 0, 0, 0);
  while (q.norm() < 0.1) q << random_vector(random), random.uniform(-1, 1);
  return Eigen::Quaterniond(q.normalized());
}

inline sim::Similarity random_similarity(Random& random) {
  return {std::exp(random.uniform(-2, 2)), random_rotation(random).toRotationMatrix(), random_vector(random, 10)};
}

inline Vector3d transformed(const sim::Similarity& s, const Vector3d& point) {
  const Vector3d turned = s.R * point;
  return s.scale * turned + s.t;
}

inline Matrix3Xd transformed(const sim::Similarity& s, const Matrix3Xd& points) {
  Matrix3Xd result(3, points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) result.col(i) = transformed(s, Vector3d(points.col(i)));
  return result;
}

inline Poses transformed(const sim::Similarity& s, Poses poses) {
  for (sim::StampedPose& pose : poses) {
    pose.T_wb = Eigen::Translation3d(transformed(s, Vector3d(pose.T_wb.translation()))) *
                Eigen::Quaterniond(Eigen::Matrix3d(s.R * pose.T_wb.linear()));
  }
  return poses;
}

inline double squares(const sim::Similarity& s, const Matrix3Xd& from, const Matrix3Xd& to) {
  return (transformed(s, from) - to).squaredNorm();
}

}  // namespace maxlogdet::test
