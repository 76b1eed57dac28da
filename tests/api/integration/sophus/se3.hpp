// SPDX-License-Identifier: MIT
#pragma once

// The part of Sophus::SE3 that ORB-SLAM3, the adapters and the tests use, under its names.

#include <Eigen/Geometry>

namespace Sophus {

template <class Number>
class SE3 {
 public:
  using Scalar = Number;
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
  using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;

  SE3() { matrix_.setIdentity(); }
  SE3(const Matrix3& rotation, const Vector3& translation) { matrix_ << rotation, translation; }
  SE3(const Eigen::Quaternion<Scalar>& rotation, const Vector3& translation)
      : SE3(Matrix3(rotation.toRotationMatrix()), translation) {}

  Eigen::Matrix<Scalar, 3, 4> matrix3x4() const { return matrix_; }

 private:
  Eigen::Matrix<Scalar, 3, 4> matrix_;
};

using SE3f = SE3<float>;
using SE3d = SE3<double>;

}  // namespace Sophus
