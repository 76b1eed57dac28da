// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

// Points and poses as trackers have them: of float or double, with a stride, row- or column-major. Eigen's are in
// maxlogdet/eigen.hpp.

namespace maxlogdet {

/// A view of n points, which are not copied: x, y, z of float or double one after the other, `stride` bytes from one
/// point to the next.
class Points {
 public:
  /// Makes a view without points.
  constexpr Points() noexcept = default;
  /// Makes a view without points.
  constexpr Points(std::nullptr_t) noexcept {}  // NOLINT(google-explicit-constructor): taken as a null pointer
  /// Takes n x 3 row-major, or rows of `stride` bytes: at least 3 doubles, and a whole number of them.
  constexpr Points(const double* xyz, std::size_t stride = 3 * sizeof(double)) noexcept  // NOLINT
      : data_(xyz), stride_(stride) {}
  /// Takes n x 3 row-major, or rows of `stride` bytes: at least 3 floats, and a whole number of them.
  constexpr Points(const float* xyz, std::size_t stride = 3 * sizeof(float)) noexcept  // NOLINT
      : data_(xyz), stride_(stride), are_float_(true) {}
  /// Takes structs with members x, y, z, in this order and next to each other, such as cv::Point3f.
  template <class Point, class Scalar = typename std::decay<decltype(std::declval<const Point&>().z)>::type,
            class = typename std::enable_if<std::is_floating_point<Scalar>::value>::type>
  Points(const Point* points) noexcept {  // NOLINT(google-explicit-constructor)
    if (points == nullptr) return;
    const bool is_triple = &points->y == &points->x + 1 && &points->z == &points->x + 2;
    *this = Points(&points->x, is_triple ? sizeof(Point) : 0);  // 0: BlockStatus::invalid_stride
  }

  /// The first x; nullptr without points.
  const void* data() const noexcept { return data_; }
  /// The number of bytes from one point to the next.
  std::size_t stride() const noexcept { return stride_; }
  /// Whether entries are float, not double.
  bool are_float() const noexcept { return are_float_; }

 private:
  const void* data_ = nullptr;
  std::size_t stride_ = 0;
  bool are_float_ = false;
};

/// A rigid transform [R | t], 3 x 4, stored as double. T_ab takes points of frame b to frame a: T_cw, world to camera.
class RigidTransform {
 public:
  /// Reads 12 entries of 3 x 4 or 4 x 4 row-major; a null pointer makes a transform that is refused as
  /// BlockStatus::invalid_pose.
  RigidTransform(const double* row_major) noexcept { read(row_major, 4, 1); }  // NOLINT(google-explicit-constructor)
  /// The same of float.
  RigidTransform(const float* row_major) noexcept { read(row_major, 4, 1); }  // NOLINT(google-explicit-constructor)
  /// Makes a transform that is refused.
  RigidTransform(std::nullptr_t) noexcept { read<double>(nullptr, 4, 1); }  // NOLINT(google-explicit-constructor)
  /// A rotation alone is not a transform.
  RigidTransform(const double (&)[9]) = delete;
  /// A rotation alone is not a transform.
  RigidTransform(const float (&)[9]) = delete;
  /// Reads column-major entries: `rows` is 4 for a 4 x 4 matrix (OpenGL's order, Eigen's default), 3 for a 3 x 4 one.
  /// Read as row-major, a 4 x 4 one would be the transposed rotation, which no check could detect.
  template <class Scalar>
  static RigidTransform column_major(const Scalar* entries, int rows) noexcept {
    RigidTransform transform;
    transform.read(entries, 1, rows);
    return transform;
  }
  /// Reads R, 3 x 3 row-major, and t apart, as OpenCV has them; if either is null, the result is refused.
  template <class Scalar>
  static RigidTransform from(const Scalar* R, const Scalar* t) noexcept {
    if (R == nullptr || t == nullptr) return nullptr;
    RigidTransform transform;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) transform.entries_[4 * row + column] = R[3 * row + column];
      transform.entries_[4 * row + 3] = t[row];
    }
    return transform;
  }
  /// Returns R = I, t = 0.
  static RigidTransform identity() noexcept {
    RigidTransform transform;
    for (std::size_t i = 0; i < 12; ++i) transform.entries_[i] = i % 5 == 0 ? 1 : 0;
    return transform;
  }

  /// 3 x 4 row-major.
  const double* data() const noexcept { return entries_; }
  /// Writes R p + t to 3 entries that do not overlap p.
  void transform(const double* p, double* to) const noexcept {
    for (std::size_t row = 0; row < 3; ++row) {
      const double* const r = entries_ + 4 * row;
      to[row] = r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3];
    }
  }

 private:
  RigidTransform() = default;
  template <class Scalar>
  void read(const Scalar* from, int row_stride, int column_stride) noexcept {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        entries_[4 * row + column] = from == nullptr
                                         ? std::numeric_limits<double>::quiet_NaN()
                                         : static_cast<double>(from[row * row_stride + column * column_stride]);
      }
    }
  }

  double entries_[12];
};

}  // namespace maxlogdet
