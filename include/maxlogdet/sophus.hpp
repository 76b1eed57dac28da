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
};

}  // namespace maxlogdet
