// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>

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

}  // namespace maxlogdet
