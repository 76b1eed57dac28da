// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace maxlogdet {

/// Zeros of a plain type that start on a cache line, so that no vector load straddles two.
template <class T>
class AlignedArray {
 public:
  static constexpr std::size_t alignment = 64;  // bytes: a cache line, and an AVX-512 register

  explicit AlignedArray(std::size_t size = 0) : memory_(new T[size + alignment / sizeof(T)]()) {
    const auto address = reinterpret_cast<std::uintptr_t>(memory_.get());
    data_ = memory_.get() + (alignment - address % alignment) % alignment / sizeof(T);
  }
  operator T*() const noexcept { return data_; }  // NOLINT(google-explicit-constructor): it is used as one

 private:
  std::unique_ptr<T[]> memory_;
  T* data_;
};

}  // namespace maxlogdet
