// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

namespace maxlogdet::sim {

/// A line on stderr, if that is a terminal, rewritten in place from two seconds on. (Debian has no C++ library for it.)
/// Not thread-safe.
class Progress {
 public:
  /// `unit`: what is counted, as in "run".
  Progress(std::string what, std::string unit) : what_(std::move(what)), unit_(std::move(unit)) {}
  ~Progress() {
    if (is_shown_) std::fputs("\r\033[K", stderr);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// The first call states what was done before.
  void update(std::size_t done, std::size_t all) {
    const auto now = Clock::now();
    if (!first_) first_ = done;
    if (now < next_ || !is_terminal_ || all == 0) return;
    next_ = now + std::chrono::milliseconds(200);
    is_shown_ = true;
    std::fprintf(stderr, "\r%s: %s %zu of %zu", what_.c_str(), unit_.c_str(), done, all);
    if (done > *first_) {
      const double a_unit = std::chrono::duration<double>(now - start_).count() / static_cast<double>(done - *first_);
      std::fprintf(stderr, ", %ld s left", std::lround(a_unit * static_cast<double>(all - done)));
    }
    std::fputs("\033[K", stderr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  std::string unit_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_ + std::chrono::seconds(2);
  bool is_terminal_ = isatty(STDERR_FILENO) == 1;
  std::optional<std::size_t> first_;
  bool is_shown_ = false;
};

}  // namespace maxlogdet::sim
