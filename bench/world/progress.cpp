// SPDX-License-Identifier: MIT
#include "bench/world/progress.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <utility>

namespace maxlogdet::sim {

Progress::Progress(std::string what, std::string unit)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      start_(Clock::now()),
      next_(start_ + std::chrono::seconds(2)),
      is_terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (is_shown_) std::fputs("\r\033[K", stderr);
}

void Progress::update(std::size_t done, std::size_t all) {
  const auto now = Clock::now();
  if (!first_) first_ = done;
  if (now < next_ || !is_terminal_ || all == 0) return;
  next_ = now + std::chrono::milliseconds(200);
  is_shown_ = true;
  constexpr std::size_t width = 30;
  std::string bar(done * width / all, '#');
  bar.resize(width, '.');
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  std::string left;
  if (done > *first_) {
    const double seconds = elapsed / static_cast<double>(done - *first_) * static_cast<double>(all - done);
    left = ", " + std::to_string(std::lround(seconds)) + " s left";
  }
  std::fprintf(stderr, "\r%s [%s] %s %zu of %zu%s\033[K", what_.c_str(), bar.c_str(), unit_.c_str(), done, all,
               left.c_str());
}

}  // namespace maxlogdet::sim
