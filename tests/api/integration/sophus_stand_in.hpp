// SPDX-License-Identifier: MIT
#pragma once

// The part of Sophus::SE3 that ORB-SLAM3 uses, under its names.

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

  Matrix3 rotationMatrix() const { return matrix_.template leftCols<3>(); }
  Vector3 translation() const { return matrix_.col(3); }
  Eigen::Matrix<Scalar, 3, 4> matrix3x4() const { return matrix_; }
  SE3 inverse() const {
    const Matrix3 transposed = rotationMatrix().transpose();
    return SE3(transposed, -(transposed * translation()));
  }
  SE3 operator*(const SE3& other) const {
    return SE3(rotationMatrix() * other.rotationMatrix(), *this * other.translation());
  }
  Vector3 operator*(const Vector3& point) const { return rotationMatrix() * point + translation(); }

 private:
  Eigen::Matrix<Scalar, 3, 4> matrix_;
};

using SE3f = SE3<float>;
using SE3d = SE3<double>;

}  // namespace Sophus
