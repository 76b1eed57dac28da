// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

namespace maxlogdet::sim {

/// A line on stderr, if that is a terminal, rewritten in place from two seconds on. (Debian has no C++ library for it.)
/// Not thread-safe.
class Progress {
 public:
  /// `unit`: what is counted, as in "run".
  Progress(std::string what, std::string unit);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// The first call states what was done before.
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
