// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {
namespace threading {

/// Decides a batch of candidates on the calling thread.
class SerialEvaluator {
 public:
  /// `rows` (1, 2 or 3) is that of the tallest block: planes of further rows are not read.
  SerialEvaluator(const simd::Kernel& kernel, const simd::Planes& planes, int rows) noexcept
      : decide_(kernel.decide[rows - 1]), planes_(planes) {}

  /// growths[j], in float64, for candidate indices[j], j in [0, count).
  void decide(const double* inverse_factor, const std::uint32_t* indices, std::size_t count,
              double* growths) const noexcept {
    decide_(planes_, inverse_factor, indices, count, growths);
  }

 private:
  simd::Decide decide_;
  simd::Planes planes_;
};

}  // namespace threading
}  // namespace maxlogdet
