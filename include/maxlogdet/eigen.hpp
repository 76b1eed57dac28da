// SPDX-License-Identifier: MIT
#pragma once

/// Header-only adapter for trackers with Eigen types. The library has no Eigen symbol: the tracker compiles this with
/// its own flags. Unaligned memory is allowed.

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/options.hpp>

#include <Eigen/Geometry>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace maxlogdet {

/// Whether entries of an Eigen type are 3 x 4 or 4 x 4, or may be, if only known at run time.
template <class Derived>
constexpr bool has_size_of_pose() noexcept {
  return (Derived::ColsAtCompileTime == 4 || Derived::ColsAtCompileTime == Eigen::Dynamic) &&
         (Derived::RowsAtCompileTime == 3 || Derived::RowsAtCompileTime == 4 ||
          Derived::RowsAtCompileTime == Eigen::Dynamic);
}
/// Whether a pointer is one to an Eigen matrix or expression of such a size.
template <class Derived>
std::integral_constant<bool, has_size_of_pose<Derived>()> is_eigen_pose(const Eigen::MatrixBase<Derived>*);
/// Anything else.
std::false_type is_eigen_pose(const void*);

/// Appends an r x 6 block, r in {1, 2, 3}, of any scalar type and storage order; returns its index. Another number of
/// rows is kept as an invalid candidate; another number of columns does not compile, or, if known only at run time, is
/// kept as invalid.
template <class Derived>
std::size_t push_back(BlockStore& blocks, const Eigen::MatrixBase<Derived>& block) {
  static_assert(Derived::ColsAtCompileTime == state_dimension || Derived::ColsAtCompileTime == Eigen::Dynamic,
                "a block has 6 columns");
  static_assert(Derived::RowsAtCompileTime <= max_block_rows, "a block has 1, 2 or 3 rows");  // Eigen::Dynamic is -1
  if (block.cols() != state_dimension || block.rows() < 1 || block.rows() > max_block_rows) {
    return blocks.push_back_invalid();
  }
  double entries[max_block_rows * state_dimension];
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, state_dimension, Eigen::RowMajor>> rows(entries, block.rows(),
                                                                                           state_dimension);
  rows = block.template cast<double>();
  return blocks.push_back(entries, static_cast<int>(block.rows()));
}

/// Poses as matrices or expressions, 3 x 4 or 4 x 4, of any scalar type and storage order. Another size does not
/// compile, or, if known only at run time, is refused as Error::invalid_pose.
template <class Derived>
struct PoseTraits<Derived, typename std::enable_if<decltype(is_eigen_pose(std::declval<Derived*>()))::value>::type> {
  /// Copies the first three rows.
  static RigidTransform convert(const Derived& T) {
    if (T.cols() != 4 || T.rows() < 3 || T.rows() > 4) return nullptr;
    double entries[12];
    Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rows(entries);
    rows = T.template topRows<3>().template cast<double>();
    return RigidTransform::row_major(entries);
  }
  /// Returns a matrix, 4 x 4 if its size is known only at run time; the fourth row is (0, 0, 0, 1).
  static typename Derived::PlainObject make(const RigidTransform& T) {
    typename Derived::PlainObject matrix;
    matrix.setIdentity(Derived::RowsAtCompileTime == 3 ? 3 : 4, 4);
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rows(T.data());
    matrix.template topRows<3>() = rows.template cast<typename Derived::Scalar>();
    return matrix;
  }
};

/// Poses as Eigen::Isometry3d, Affine3f, ...
template <class Scalar, int Mode, int Options>
struct PoseTraits<Eigen::Transform<Scalar, 3, Mode, Options>> {
  /// Copies its matrix.
  static RigidTransform convert(const Eigen::Transform<Scalar, 3, Mode, Options>& T) { return T.matrix(); }
  /// Returns the transform.
  static Eigen::Transform<Scalar, 3, Mode, Options> make(const RigidTransform& T) {
    using Matrix = typename Eigen::Transform<Scalar, 3, Mode, Options>::MatrixType;
    return Eigen::Transform<Scalar, 3, Mode, Options>(PoseTraits<Matrix>::make(T));
  }
};

/// Poses of Sophus: Sophus::SE3d, SE3f, their maps, and any other type whose matrix3x4() is Eigen's.
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
