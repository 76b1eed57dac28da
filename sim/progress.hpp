// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

namespace maxlogdet::sim {

/// One line on stderr, rewritten in place, from two seconds on, when that is a terminal. (Debian has no C++ library for
/// it.) Not for several threads at once.
class Progress {
 public:
  /// `unit`: what is counted, as in "run".
  Progress(std::string what, std::string unit);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// The first call tells what was done before.
  void update(std::size_t done, std::size_t all);

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  std::string unit_;
  Clock::time_point start_;
  Clock::time_point next_;
  bool is_terminal_;
  std::optional<std::size_t> first_;
  bool is_shown_ = false;
};

}  // namespace maxlogdet::sim
