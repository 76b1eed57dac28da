// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cmath>
#include <limits>

namespace maxlogdet {

/// The time at which a search ends with the answer so far, or a call hands on what is left. Without a limit the clock
/// is never read.
class Deadline {
 public:
  /// `seconds` from now; 0: never.
  explicit Deadline(double seconds = 0) noexcept
      : limit_(seconds), start_(seconds > 0 ? Clock::now() : Clock::time_point()) {}

  bool has_passed() const noexcept { return limit_ > 0 && spent() >= limit_; }

  /// What is left, s: the shortest time that is none where the limit has passed; 0, and what is refused, stay.
  double left() const noexcept {
    return limit_ > 0 ? std::fmax(limit_ - spent(), std::numeric_limits<double>::min()) : limit_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  double spent() const noexcept { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  double limit_;
  Clock::time_point start_;
};

}  // namespace maxlogdet
