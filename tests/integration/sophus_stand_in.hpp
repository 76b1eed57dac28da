// SPDX-License-Identifier: MIT
#pragma once

// The little of Sophus::SE3 that ORB-SLAM3 and Basalt show, under its names.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace Sophus {

template <class Scalar>
class SE3 {
 public:
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
  using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;

  SE3() = default;
  SE3(const Matrix3& rotation, const Vector3& translation) : rotation_(rotation), translation_(translation) {}

  Matrix3 rotationMatrix() const { return rotation_; }
  const Vector3& translation() const { return translation_; }
  Eigen::Matrix<Scalar, 3, 4> matrix3x4() const {
    Eigen::Matrix<Scalar, 3, 4> matrix;
    matrix << rotation_, translation_;
    return matrix;
  }
  SE3 inverse() const { return SE3(rotation_.transpose(), -(rotation_.transpose() * translation_)); }
  SE3 operator*(const SE3& other) const {
    return SE3(rotation_ * other.rotation_, rotation_ * other.translation_ + translation_);
  }
  Vector3 operator*(const Vector3& point) const { return rotation_ * point + translation_; }

 private:
  Matrix3 rotation_ = Matrix3::Identity();
  Vector3 translation_ = Vector3::Zero();
};

using SE3f = SE3<float>;
using SE3d = SE3<double>;

}  // namespace Sophus
