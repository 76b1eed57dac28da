// SPDX-License-Identifier: MIT
#pragma once

/// Poses and points of OpenCV. Points such as cv::Point3f and cv::Vec3d need no header.

#include <maxlogdet/inputs.hpp>

#include <limits>
#include <opencv2/core/core.hpp>
#include <type_traits>

namespace maxlogdet {

/// An entry of a matrix of type CV_32F or CV_64F; NaN of another one.
inline double entry_of(const cv::Mat& m, int row, int column) {
  if (m.type() == CV_32F) return static_cast<double>(m.at<float>(row, column));
  return m.type() == CV_64F ? m.at<double>(row, column) : std::numeric_limits<double>::quiet_NaN();
}

/// Poses as cv::Mat, cv::Mat_ or cv::MatExpr, 3 x 4 or 4 x 4, CV_32F or CV_64F; another size or type, as of an empty
/// one, is refused as Error::invalid_pose.
template <class Matrix>
struct PoseTraits<Matrix, typename std::enable_if<std::is_convertible<const Matrix&, cv::Mat>::value>::type> {
  /// Copies the first three rows.
  static RigidTransform convert(const cv::Mat& T) {
    if (T.cols != 4 || T.rows < 3 || T.rows > 4) return nullptr;
    double entries[12];
    for (int i = 0; i < 12; ++i) entries[i] = entry_of(T, i / 4, i % 4);
    return RigidTransform::row_major(entries);
  }
  /// Returns a cv::Mat of its own memory, 4 x 4, CV_64F.
  template <class Own = Matrix>
  static typename std::enable_if<std::is_same<Own, cv::Mat>::value, cv::Mat>::type make(const RigidTransform& T) {
    cv::Mat matrix(4, 4, CV_64F);
    for (int i = 0; i < 16; ++i) matrix.at<double>(i / 4, i % 4) = i < 12 ? T.data()[i] : i / 15;
    return matrix;
  }
};

/// Poses as cv::Matx34d, cv::Matx44f, ...
template <class Scalar, int rows>
struct PoseTraits<cv::Matx<Scalar, rows, 4>, typename std::enable_if<rows == 3 || rows == 4>::type> {
  /// Copies the first three rows.
  static RigidTransform convert(const cv::Matx<Scalar, rows, 4>& T) { return RigidTransform::row_major(T.val); }
  /// Returns the matrix; the fourth row is (0, 0, 0, 1).
  static cv::Matx<Scalar, rows, 4> make(const RigidTransform& T) {
    cv::Matx<Scalar, rows, 4> matrix = cv::Matx<Scalar, rows, 4>::eye();
    for (int i = 0; i < 12; ++i) matrix.val[i] = static_cast<Scalar>(T.data()[i]);
    return matrix;
  }
};

/// Points as cv::Mat, cv::Mat_ or cv::MatExpr, a row or a column of 3 (a pixel: 2) entries, CV_32F or CV_64F; of
/// another type or size they are NaN, which no function selects.
template <class Matrix>
struct PointTraits<Matrix, typename std::enable_if<std::is_convertible<const Matrix&, cv::Mat>::value>::type> {
  /// Copies two entries.
  static void read_two(const cv::Mat& v, double* to) { read(v, 2, to); }
  /// Copies three entries.
  static void read_three(const cv::Mat& v, double* to) { read(v, 3, to); }

 private:
  static void read(const cv::Mat& v, int count, double* to) {
    const bool is_column = v.rows == count && v.cols == 1;
    const bool is_row = v.rows == 1 && v.cols == count;
    for (int i = 0; i < count; ++i) {
      to[i] = is_column || is_row ? entry_of(v, is_column ? i : 0, is_row ? i : 0)
                                  : std::numeric_limits<double>::quiet_NaN();
    }
  }
};

}  // namespace maxlogdet
