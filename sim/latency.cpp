// SPDX-License-Identifier: MIT
#include "sim/latency.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace maxlogdet::sim {

namespace {

using Clock = std::chrono::steady_clock;

// One line, rewritten in place; Debian has no C++ library for it.
class Progress {
 public:
  explicit Progress(std::string what) : what_(std::move(what)), next_(Clock::now() + std::chrono::seconds(2)) {}
  ~Progress() {
    if (is_shown_) std::fputs("\r\033[K", stderr);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::size_t done, std::size_t all) {
    const auto now = Clock::now();
    if (now < next_ || !is_terminal_) return;
    next_ = now + std::chrono::milliseconds(200);
    is_shown_ = true;
    std::fprintf(stderr, "\r%s: call %zu of %zu (%zu %%)", what_.c_str(), done, all, 100 * done / all);
  }

 private:
  std::string what_;
  Clock::time_point next_;
  bool is_terminal_ = isatty(STDERR_FILENO) == 1;
  bool is_shown_ = false;
};

}  // namespace

Latency latency_of(std::vector<double> microseconds) {
  std::sort(microseconds.begin(), microseconds.end());
  const auto quantile = [&](double q) {
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(microseconds.size())));
    return microseconds[std::max<std::size_t>(rank, 1) - 1];
  };
  return {quantile(0.5), quantile(0.99), microseconds.back(), quantile(0.999)};
}

Latency measure_latency(const std::string& what, std::size_t repeat, const std::function<void()>& work) {
  work();
  std::vector<double> microseconds(std::max<std::size_t>(repeat, 1));
  Progress progress(what);
  for (std::size_t i = 0; i < microseconds.size(); ++i) {
    const auto start = Clock::now();
    work();
    microseconds[i] = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    progress.update(i + 1, microseconds.size());
  }
  return latency_of(std::move(microseconds));
}

}  // namespace maxlogdet::sim
