// SPDX-License-Identifier: MIT
#pragma once

/// Poses of Sophus: Sophus::SE3d, SE3f, their maps, and any other type whose matrix3x4() is Eigen's.

#include <maxlogdet/eigen.hpp>

#include <utility>

namespace maxlogdet {

/// A group element with matrix3x4().
template <class Group>
struct PoseTraits<Group, decltype(static_cast<void>(std::declval<const Group&>().matrix3x4()))> {
  /// Copies its matrix.
  static RigidTransform convert(const Group& T) { return T.matrix3x4(); }
  /// Returns the element, by a unit quaternion.
  static Group make(const RigidTransform& T) {
    using Scalar = typename Group::Scalar;
    const Eigen::Matrix<double, 3, 4> matrix = PoseTraits<Eigen::Matrix<double, 3, 4>>::make(T);
    const Eigen::Quaternion<double> rotation(Eigen::Matrix3d(matrix.leftCols<3>()));
    const Eigen::Vector3d t = matrix.col(3);
    return Group(rotation.cast<Scalar>().normalized(), t.cast<Scalar>());
  }
};

}  // namespace maxlogdet
