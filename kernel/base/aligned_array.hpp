// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace maxlogdet {

constexpr std::size_t line_size = 64;  ///< bytes of a cache line, and of an AVX-512 register

/// The first element of memory that starts a cache line.
template <class T>
T* first_on_a_line(T* memory) noexcept {
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  return memory + (line_size - address % line_size) % line_size / sizeof(T);
}

/// Zeros of a plain type that start on a cache line, so that no vector load straddles two.
template <class T>
class AlignedArray {
 public:
  explicit AlignedArray(std::size_t size = 0)
      : memory_(new T[size + line_size / sizeof(T)]()), data_(first_on_a_line(memory_.get())) {}
  operator T*() const noexcept { return data_; }  // NOLINT(google-explicit-constructor): it is used as one

 private:
  std::unique_ptr<T[]> memory_;
  T* data_;
};

}  // namespace maxlogdet
