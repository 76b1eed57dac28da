// SPDX-License-Identifier: MIT
#pragma once

// The part of OpenCV that ORB-SLAM's frames use, under its names.

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

namespace cv {

struct Point2f {
  float x = 0;
  float y = 0;
};

struct KeyPoint {
  Point2f pt;
  int octave = 0;
};

/// A matrix of float. Copies share their entries, as those of the real one do.
class Mat {
 public:
  Mat() = default;
  Mat(int rows_in, int cols_in)
      : rows(rows_in),
        cols(cols_in),
        entries_(std::make_shared<std::vector<float>>(static_cast<std::size_t>(rows_in * cols_in))) {}

  bool empty() const { return entries_ == nullptr; }

  template <class T>
  T& at(int row, int column) {
    return entry<T>(row * cols + column);
  }
  template <class T>
  const T& at(int row, int column) const {
    return entry<T>(row * cols + column);
  }
  template <class T>
  T& at(int i) {
    return entry<T>(i);
  }
  template <class T>
  const T& at(int i) const {
    return entry<T>(i);
  }

  /// The first row; null of an empty one.
  template <class T>
  const T* ptr(int row = 0) const {
    return empty() ? nullptr : &entry<T>(row * cols);
  }
  template <class T>
  T* ptr(int row = 0) {
    return empty() ? nullptr : &entry<T>(row * cols);
  }

  Mat clone() const {
    Mat copy = *this;
    if (!empty()) copy.entries_ = std::make_shared<std::vector<float>>(*entries_);
    return copy;
  }

  int rows = 0;
  int cols = 0;

 private:
  template <class T>
  T& entry(int i) const {
    static_assert(std::is_same<T, float>::value, "the real one would read rubbish");
    return entries_->at(static_cast<std::size_t>(i));
  }

  std::shared_ptr<std::vector<float>> entries_;
};

}  // namespace cv
