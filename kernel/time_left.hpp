// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cmath>
#include <limits>

namespace maxlogdet {

/// A time limit that counts from its construction, at the beginning of a call, and is handed on to others.
class TimeLeft {
 public:
  explicit TimeLeft(double limit) noexcept : limit_(limit), start_(limit > 0 ? Clock::now() : Clock::time_point()) {}

  /// What is left, s: the shortest time that is none where the limit has passed; 0, and what is refused, stay.
  double seconds() const noexcept {
    if (!(limit_ > 0)) return limit_;
    const double spent = std::chrono::duration<double>(Clock::now() - start_).count();
    return std::fmax(limit_ - spent, std::numeric_limits<double>::min());
  }

 private:
  using Clock = std::chrono::steady_clock;
  double limit_;
  Clock::time_point start_;
};

}  // namespace maxlogdet
