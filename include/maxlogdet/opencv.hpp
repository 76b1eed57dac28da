// SPDX-License-Identifier: MIT
#pragma once

/// Poses and points of OpenCV. Points such as cv::Point3f and cv::Vec3d need no header.

#include <maxlogdet/inputs.hpp>

#include <limits>
#include <opencv2/core.hpp>
#include <type_traits>

namespace maxlogdet {

/// Poses as cv::Mat, 3 x 4 or 4 x 4, CV_32F or CV_64F; another size or type, as of an empty one, is refused as
/// Error::invalid_pose.
template <>
struct PoseTraits<cv::Mat> {
  /// Copies the first three rows.
  static RigidTransform convert(const cv::Mat& T) {
    if (T.cols != 4 || T.rows < 3 || T.rows > 4) return nullptr;
    if (T.type() == CV_32F) return read<float>(T);
    return T.type() == CV_64F ? read<double>(T) : RigidTransform(nullptr);
  }

 private:
  template <class Scalar>
  static RigidTransform read(const cv::Mat& T) {
    Scalar entries[12];
    for (int i = 0; i < 12; ++i) entries[i] = T.at<Scalar>(i / 4, i % 4);
    return RigidTransform::row_major(entries);
  }
};

/// Poses as cv::Matx34d, cv::Matx44f, ...
template <class Scalar, int rows>
struct PoseTraits<cv::Matx<Scalar, rows, 4>, typename std::enable_if<rows == 3 || rows == 4>::type> {
  /// Copies the first three rows.
  static RigidTransform convert(const cv::Matx<Scalar, rows, 4>& T) { return RigidTransform::row_major(T.val); }
};

/// Points as cv::Mat of 3 (a pixel: 2) entries, CV_32F or CV_64F; of another type or size they are NaN, which no
/// function selects.
template <>
struct PointTraits<cv::Mat> {
  /// Copies two entries.
  static void read_two(const cv::Mat& v, double* to) { read(v, 2, to); }
  /// Copies three entries.
  static void read_three(const cv::Mat& v, double* to) { read(v, 3, to); }

 private:
  static void read(const cv::Mat& v, int count, double* to) {
    const bool is_vector = v.rows * v.cols == count && (v.type() == CV_32F || v.type() == CV_64F);
    for (int i = 0; i < count; ++i) {
      to[i] = !is_vector           ? std::numeric_limits<double>::quiet_NaN()
              : v.type() == CV_32F ? static_cast<double>(v.at<float>(i))
                                   : v.at<double>(i);
    }
  }
};

}  // namespace maxlogdet
