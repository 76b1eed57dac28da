// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace maxlogdet {

/// The time at which a search ends with the answer so far. Without a limit the clock is never read.
class Deadline {
 public:
  /// `seconds` from now; 0: never.
  explicit Deadline(double seconds) noexcept
      : limit_(seconds), start_(seconds > 0 ? Clock::now() : Clock::time_point()) {}

  bool has_passed() const noexcept {
    return limit_ > 0 && std::chrono::duration<double>(Clock::now() - start_).count() >= limit_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  double limit_;
  Clock::time_point start_;
};

}  // namespace maxlogdet
