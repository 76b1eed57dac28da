// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>

// The kernel that profiles/roofline measures: all that it knows of kernel/ and simd/ is here and in full_round.cpp.

namespace maxlogdet::profiles {

/// Of one gain. A fused multiply-add is 2 flops and 1 vector operation; what the answer does not need (conversions,
/// loads, comparisons) is not counted, a division as 1.
struct Arithmetic {
  int flops;
  int vector_operations;
};

/// Screening in float32: Y = H W^T takes 6 products and 15 fused multiply-adds a row; a dot product of two rows 2, 4
/// and an addition, with three rows 1 and 5; the relative gain what relative_gain_by_minors in simd/screen.inl writes
/// down.
constexpr const char* arithmetic_name = "float32, fused";
constexpr std::size_t element_bytes = 4;
constexpr Arithmetic gain_arithmetic[3] = {{47, 28}, {110, 66}, {200, 118}};  // [rows - 1]

/// One evaluation of the gains of all candidates with one instruction set, in the middle of a selection.
class FullRound {
 public:
  static constexpr std::size_t candidates = 2000;

  /// `isa` is one that this machine supports; rows is 2 or 3.
  FullRound(const std::string& isa, int rows);
  FullRound(FullRound&&) noexcept;
  FullRound& operator=(FullRound&&) noexcept;
  ~FullRound();

  void operator()() noexcept;

  /// Read and written for one gain: the entries of its block, whether it remains, and the gain itself.
  static constexpr std::size_t bytes_per_gain(int rows) {
    return static_cast<std::size_t>(6 * rows + 2) * element_bytes;
  }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet::profiles
