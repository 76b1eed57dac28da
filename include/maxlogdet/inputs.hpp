// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

// Points and poses of the tracker's own types. A point is anything with members x, y, z, or with [0], [1], [2]:
// cv::Point3f, Eigen::Vector3d, std::array, a pointer. A pose is whatever PoseTraits knows: maxlogdet/eigen.hpp and
// maxlogdet/opencv.hpp teach it theirs, and a tracker its own in five lines.

namespace maxlogdet {

/// Where the coordinates of a foreign type are; undefined for what is no point. Specialise it for a type that has
/// neither members x, y, z nor [0], [1], [2].
template <class Vector, class = void>
struct PointTraits;

/// Whether a type has a member y.
template <class Vector, class = void>
struct HasMemberY : std::false_type {};
/// It has.
template <class Vector>
struct HasMemberY<Vector, decltype(static_cast<void>(static_cast<double>(std::declval<const Vector&>().y)))>
    : std::true_type {};

/// Members x, y and, of a point in space, z.
template <class Vector>
struct PointTraits<Vector, typename std::enable_if<HasMemberY<Vector>::value>::type> {
  /// Copies x, y to `to`.
  static void read_two(const Vector& v, double* to) noexcept {
    to[0] = static_cast<double>(v.x);
    to[1] = static_cast<double>(v.y);
  }
  /// Copies x, y, z to `to`.
  static void read_three(const Vector& v, double* to) noexcept {
    read_two(v, to);
    to[2] = static_cast<double>(v.z);
  }
};

/// How many entries a vector says it has.
template <class Vector>
auto entry_count(const Vector& v, int) -> decltype(static_cast<std::size_t>(v.size())) {
  return static_cast<std::size_t>(v.size());
}
/// As many as are read, where it cannot say, as of a pointer.
template <class Vector>
std::size_t entry_count(const Vector&, long) noexcept {
  return 3;
}

/// [0], [1] and, of a point in space, [2]; NaN, which no function selects, where size() is less.
template <class Vector>
struct PointTraits<
    Vector,
    typename std::enable_if<
        !HasMemberY<Vector>::value &&
        std::is_arithmetic<typename std::decay<decltype(std::declval<const Vector&>()[0])>::type>::value>::type> {
  /// Copies [0], [1] to `to`.
  static void read_two(const Vector& v, double* to) {
    const bool is_long_enough = entry_count(v, 0) >= 2;
    to[0] = is_long_enough ? static_cast<double>(v[0]) : std::numeric_limits<double>::quiet_NaN();
    to[1] = is_long_enough ? static_cast<double>(v[1]) : std::numeric_limits<double>::quiet_NaN();
  }
  /// Copies [0], [1], [2] to `to`.
  static void read_three(const Vector& v, double* to) {
    read_two(v, to);
    to[2] = entry_count(v, 0) >= 3 ? static_cast<double>(v[2]) : std::numeric_limits<double>::quiet_NaN();
  }
};

/// A map point, world frame, m: copied from any type with PointTraits.
struct WorldPoint {
  double xyz[3];  ///< coordinates

  /// Copies a point.
  template <class Vector, class Traits = PointTraits<Vector>, class = decltype(&Traits::read_three)>
  WorldPoint(const Vector& p_w) {  // NOLINT(google-explicit-constructor): taken for a point
    Traits::read_three(p_w, xyz);
  }
};

/// A measurement in the image, u, v, px: copied from any type with PointTraits.
struct Pixel {
  double uv[2];  ///< coordinates

  /// Copies a pixel.
  template <class Vector, class Traits = PointTraits<Vector>, class = decltype(&Traits::read_two)>
  Pixel(const Vector& measured) {  // NOLINT(google-explicit-constructor): taken for a pixel
    Traits::read_two(measured, uv);
  }
};

/// How a foreign pose becomes a RigidTransform, and back; undefined for what is no pose. A specialisation has
///
///   static RigidTransform convert(const Pose& T);
///   static Pose make(const RigidTransform& T);    // where a RigidTransform should convert to it, as good.pose()
template <class Pose, class = void>
struct PoseTraits;

/// A rigid transform [R | t], 3 x 4, stored as double. T_ab takes points of frame b to frame a: T_cw, world to camera.
class RigidTransform {
 public:
  /// Converts a pose of a foreign type, whose order the compiler knows (PoseTraits).
  template <class Pose, class Traits = PoseTraits<Pose>, class = decltype(Traits::convert(std::declval<const Pose&>()))>
  RigidTransform(const Pose& T) : RigidTransform(Traits::convert(T)) {}  // NOLINT(google-explicit-constructor)
  /// Makes a transform that is refused: Error::invalid_pose.
  RigidTransform(std::nullptr_t) noexcept { read<double>(nullptr, 4, 1); }  // NOLINT(google-explicit-constructor)
  /// Reads the first 12 entries of a row-major matrix, 3 x 4 or 4 x 4, of float or double; a null pointer makes a
  /// transform that is refused.
  template <class Scalar>
  static RigidTransform row_major(const Scalar* entries) noexcept {
    RigidTransform transform;
    transform.read(entries, 4, 1);
    return transform;
  }
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

  /// Converts to a foreign type, as in Eigen::Isometry3d T_cw = good.pose();
  template <class Pose, class Traits = PoseTraits<Pose>,
            class = typename std::enable_if<
                std::is_same<Pose, decltype(Traits::make(std::declval<const RigidTransform&>()))>::value>::type>
  operator Pose() const {  // NOLINT(google-explicit-constructor)
    return Traits::make(*this);
  }
  /// The largest |entry| of R R^T - I: transforms beyond 1e-3 are refused. Infinite if some entry is not finite.
  double rotation_error() const noexcept;
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
