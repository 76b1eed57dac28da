// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>

// The kernel that profiles/roofline measures. Only this header and full_round.cpp depend on kernel/ and simd/.

namespace maxlogdet::profiles {

/// The arithmetic of one gain. A fused multiply-add counts as 2 flops and 1 vector operation, a division as 1;
/// conversions, loads and comparisons do not count.
struct Arithmetic {
  int flops;
  int vector_operations;
};

/// Screening in float32: Y = H W^T takes 6 products and 15 fused multiply-adds per row; a dot product of two rows takes
/// 2, 4 and an addition, with three rows 1 and 5; the relative gain takes what relative_gain_by_minors in
/// simd/gains.inl does.
constexpr const char* arithmetic_name = "float32, fused";
constexpr std::size_t element_bytes = 4;
constexpr Arithmetic gain_arithmetic[3] = {{47, 28}, {110, 66}, {200, 118}};  // [rows - 1]

/// Evaluates the gains of all candidates with one instruction set, in the middle of a selection.
class FullRound {
 public:
  static constexpr std::size_t candidates = 2000;

  /// `isa` is one that this machine supports; rows is 2 or 3.
  FullRound(const std::string& isa, int rows);
  FullRound(FullRound&&) noexcept;
  FullRound& operator=(FullRound&&) noexcept;
  ~FullRound();

  void operator()() noexcept;

  /// Bytes read and written for one gain: the entries of its block, whether it remains, and the gain itself.
  static constexpr std::size_t bytes_per_gain(int rows) {
    return static_cast<std::size_t>(6 * rows + 2) * element_bytes;
  }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet::profiles
