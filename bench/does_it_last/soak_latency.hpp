// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace maxlogdet::bench {

/// A histogram of latencies in steps of 2^(1/32), 2 %, whose memory does not grow with their number.
class LatencyHistogram {
 public:
  void add(double microseconds) noexcept {
    const double step = steps_per_octave * std::log2(std::max(microseconds, lowest) / lowest);
    ++counts_[std::min(static_cast<std::size_t>(step), counts_.size() - 1)];
    ++calls_;
    max_ = std::max(max_, microseconds);
  }

  std::uint64_t calls() const noexcept { return calls_; }
  double max() const noexcept { return max_; }  ///< us

  /// The upper end of the step that contains this quantile, us; 0 without calls.
  double quantile(double share) const noexcept {
    const double wanted = share * static_cast<double>(calls_);
    std::uint64_t seen = 0;
    for (std::size_t step = 0; step < counts_.size(); ++step) {
      seen += counts_[step];
      if (seen > 0 && static_cast<double>(seen) >= wanted) return std::min(end_of(step), max_);
    }
    return max_;
  }

  /// Calls body(upper end of the step in us, number of calls in it) for each step that is not empty.
  template <class Body>
  void for_each(const Body& body) const {
    for (std::size_t step = 0; step < counts_.size(); ++step) {
      if (counts_[step] > 0) body(end_of(step), counts_[step]);
    }
  }

 private:
  static constexpr double lowest = 0.01;  // us; anything faster counts as this
  static constexpr double steps_per_octave = 32;

  static double end_of(std::size_t step) noexcept {
    return lowest * std::exp2(static_cast<double>(step + 1) / steps_per_octave);
  }

  std::array<std::uint64_t, 1024> counts_{};  // up to 43 s
  std::uint64_t calls_ = 0;
  double max_ = 0;
};

}  // namespace maxlogdet::bench
