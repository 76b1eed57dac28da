// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <utility>

namespace maxlogdet {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr float float_infinity = std::numeric_limits<float>::infinity();

constexpr std::size_t max_capacity = std::numeric_limits<std::uint32_t>::max();  // indices have 32 bits

/// The capacity; throws std::bad_alloc if it is above the maximum.
inline std::size_t checked_capacity(std::size_t capacity) {
  if (capacity > max_capacity) throw std::bad_alloc();
  return capacity;
}

constexpr std::size_t line_size = 64;  ///< bytes of a cache line and of an AVX-512 register

/// The first element of `memory` on a cache-line boundary.
template <class T>
T* first_on_a_line(T* memory) noexcept {
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  return memory + (line_size - address % line_size) % line_size / sizeof(T);
}

/// A zero-initialised array of a trivial type, aligned to a cache line, so that no vector load straddles two lines. It
/// is used as a pointer.
template <class T>
class AlignedArray {
 public:
  explicit AlignedArray(std::size_t size = 0)
      : memory_(new T[size + line_size / sizeof(T)]()), data_(first_on_a_line(memory_.get())) {}
  operator T*() const noexcept { return data_; }  // NOLINT(google-explicit-constructor)

 private:
  std::unique_ptr<T[]> memory_;
  T* data_;
};

/// The same with an element for each candidate, lane or tile.
template <class Number, class T>
class ArrayOf {
 public:
  explicit ArrayOf(std::size_t size = 0) : array_(size) {}
  T& operator[](Number i) const noexcept { return array_[static_cast<std::size_t>(i)]; }
  T* data() const noexcept { return array_; }
  void swap(ArrayOf& other) noexcept { std::swap(array_, other.array_); }

 private:
  AlignedArray<T> array_;
};

}  // namespace maxlogdet
