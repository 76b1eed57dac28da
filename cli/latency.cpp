// SPDX-License-Identifier: MIT
#include "cli/latency.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace maxlogdet::cli {

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

Latency measure_latency(const std::string& what, std::size_t repeat, const std::function<void()>& work) {
  work();
  std::vector<double> times(std::max<std::size_t>(repeat, 1));
  Progress progress(what);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto start = Clock::now();
    work();
    times[i] = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    progress.update(i + 1, times.size());
  }
  std::sort(times.begin(), times.end());
  const auto quantile = [&](double q) {  // nearest rank
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(times.size())));
    return times[std::max<std::size_t>(rank, 1) - 1];
  };
  return {quantile(0.5), quantile(0.99), times.back()};
}

}  // namespace maxlogdet::cli
