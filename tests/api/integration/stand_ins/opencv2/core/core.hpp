// SPDX-License-Identifier: MIT
#pragma once

// The part of OpenCV that maxlogdet/opencv.hpp and ORB-SLAM's frames use, under its names.

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <vector>

#define CV_8U 0
#define CV_32F 5
#define CV_64F 6

namespace cv {

struct Point2f {
  float x = 0;
  float y = 0;
};

struct Point3f {
  float x = 0;
  float y = 0;
  float z = 0;
};

struct Point3d {
  double x = 0;
  double y = 0;
  double z = 0;
};

struct KeyPoint {
  Point2f pt;
  int octave = 0;
};

/// A matrix of float or double. Copies share their entries, as those of the real one do.
class Mat {
 public:
  Mat() = default;
  Mat(int rows_in, int cols_in, int type) : rows(rows_in), cols(cols_in), type_(type) {
    const auto size = static_cast<std::size_t>(rows * cols);
    if (type == CV_32F) floats_ = std::make_shared<std::vector<float>>(size);
    if (type == CV_64F) doubles_ = std::make_shared<std::vector<double>>(size);
  }

  bool empty() const { return rows * cols == 0; }
  int type() const { return type_; }

  template <class T>
  T& at(int row, int column) {
    return entry(row * cols + column, T());
  }
  template <class T>
  const T& at(int row, int column) const {
    return entry(row * cols + column, T());
  }
  template <class T>
  T& at(int i) {
    return entry(i, T());
  }
  template <class T>
  const T& at(int i) const {
    return entry(i, T());
  }

  Mat clone() const {
    Mat copy = *this;
    if (floats_ != nullptr) copy.floats_ = std::make_shared<std::vector<float>>(*floats_);
    if (doubles_ != nullptr) copy.doubles_ = std::make_shared<std::vector<double>>(*doubles_);
    return copy;
  }

  int rows = 0;
  int cols = 0;

 private:
  float& entry(int i, float) const { return entry_of(floats_.get(), i); }
  double& entry(int i, double) const { return entry_of(doubles_.get(), i); }
  template <class T>
  static T& entry_of(std::vector<T>* entries, int i) {
    if (entries == nullptr) throw std::logic_error("another type: the real one would read rubbish");
    return entries->at(static_cast<std::size_t>(i));
  }

  int type_ = CV_8U;
  std::shared_ptr<std::vector<float>> floats_;
  std::shared_ptr<std::vector<double>> doubles_;
};

/// A matrix whose type the compiler knows.
template <class T>
class Mat_ : public Mat {
 public:
  Mat_(int rows_in, int cols_in) : Mat(rows_in, cols_in, std::is_same<T, float>::value ? CV_32F : CV_64F) {}
  T* operator[](int row) { return &at<T>(row, 0); }
  const T* operator[](int row) const { return &at<T>(row, 0); }
};

/// What an operator on matrices returns.
class MatExpr {
 public:
  explicit MatExpr(const Mat& m) : result_(m) {}
  operator Mat() const { return result_; }  // NOLINT(google-explicit-constructor): as the real one

 private:
  Mat result_;
};

template <class T, int m, int n>
class Matx {
 public:
  T val[m * n] = {};
};

template <class T, int count>
class Vec : public Matx<T, count, 1> {
 public:
  const T& operator[](int i) const { return this->val[i]; }
  T& operator[](int i) { return this->val[i]; }
};

using Matx34d = Matx<double, 3, 4>;
using Matx44f = Matx<float, 4, 4>;
using Matx33d = Matx<double, 3, 3>;
using Vec3d = Vec<double, 3>;

}  // namespace cv
