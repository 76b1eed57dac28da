// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {
namespace threading {

/// Evaluates a batch of candidates on the calling thread. What strategies ask of an evaluator is these two calls; one
/// that spreads a batch over cores answers the same calls with the same bits.
class SerialEvaluator {
 public:
  /// `rows` (1, 2 or 3) is that of the tallest block: planes of further rows are not read.
  SerialEvaluator(const simd::Kernel& kernel, const simd::Planes& planes, int rows) noexcept
      : range_(kernel.evaluate_range[rows - 1]), listed_(kernel.evaluate_listed[rows - 1]), planes_(planes) {}

  /// growths[i] for every candidate i in [begin, end).
  void range(const double* inverse_factor, std::size_t begin, std::size_t end, double* growths) const noexcept {
    range_(planes_, inverse_factor, begin, end, growths);
  }

  /// growths[j] for candidate indices[j], j in [0, count).
  void listed(const double* inverse_factor, const std::uint32_t* indices, std::size_t count,
              double* growths) const noexcept {
    listed_(planes_, inverse_factor, indices, count, growths);
  }

 private:
  simd::EvaluateRange range_;
  simd::EvaluateListed listed_;
  simd::Planes planes_;
};

}  // namespace threading
}  // namespace maxlogdet
