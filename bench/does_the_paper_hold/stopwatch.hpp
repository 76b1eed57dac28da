// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace maxlogdet::sim {

/// Runs from its construction on.
class Stopwatch {
 public:
  /// Adds the time since the last lap to `ms`.
  void lap(double& ms) {
    const auto now = Clock::now();
    ms += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace maxlogdet::sim
