// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <iterator>
#include <limits>
#include <type_traits>

// What all targets use: input as values, and properties that have to hold.

namespace maxlogdet::fuzz {

/// A fuzzer's input, read value by value, zeros after its end: every input is valid and means the same on every
/// machine.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  bool is_empty() const { return left_ == 0; }

  /// The next sizeof(T) bytes as they are.
  template <class T>
  T raw() {
    static_assert(std::is_arithmetic<T>::value, "of anything else not all bits are values");
    T value{};
    const std::size_t size = std::min(sizeof value, left_);
    if (size > 0) std::memcpy(&value, data_, size);
    skip(size);
    return value;
  }

  std::uint8_t byte() { return raw<std::uint8_t>(); }

  /// 0 <= result < end, end >= 1; read from one byte if possible.
  std::size_t below(std::size_t end) { return end <= 256 ? byte() % end : raw<std::uint32_t>() % end; }

  /// True in `cases` of 256 cases; never after the end.
  bool chance(int cases) { return byte() >= 256 - cases; }

  /// Any number: mostly small integers, also times a power of ten, any bits of a float64 or a float32, and the ends of
  /// both.
  double number() {
    constexpr double edges[] = {std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::max(),
                                std::numeric_limits<double>::denorm_min(),
                                static_cast<double>(std::numeric_limits<float>::max()),
                                0x1.fffffefffffffp127,  // the largest that is not rounded beyond float32
                                0x1.ffffffp127,         // the smallest that is
                                static_cast<double>(std::numeric_limits<float>::min()),
                                static_cast<double>(std::numeric_limits<float>::denorm_min()),
                                -0.0};
    switch (below(8)) {
      case 4: return raw<double>();
      case 5: return static_cast<double>(raw<float>());
      case 6: return static_cast<double>(byte()) / 256;
      case 7: return edges[below(std::size(edges))];
      case 3: return times_power_of_ten(raw<std::int8_t>());
      default: return raw<std::int8_t>();
    }
  }

  /// A factor from 1e-40 to 1e40.
  double times_power_of_ten(double factor) { return factor * std::pow(10.0, raw<std::int8_t>() % 41); }

 private:
  void skip(std::size_t size) {
    if (size > 0) data_ += size;
    left_ -= size;
  }

  const std::uint8_t* data_;
  std::size_t left_;
};

/// Ends the program, so that a fuzzer takes it for a finding, if a property does not hold, and says so in one line.
template <class... Details>
void require(bool holds, const char* property, const Details&... details) {
  if (holds) return;
  std::cerr.precision(17);
  std::cerr << "does not hold: " << property;
  ((std::cerr << ' ' << details), ...);
  std::cerr << std::endl;  // NOLINT(performance-avoid-endl): abort() flushes nothing
  std::abort();
}

}  // namespace maxlogdet::fuzz
