// SPDX-License-Identifier: MIT
#include "bench/world/latency.hpp"

#include "bench/world/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

namespace maxlogdet::sim {

namespace {

using Clock = std::chrono::steady_clock;

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
  Progress progress(what, "call");
  for (std::size_t i = 0; i < microseconds.size(); ++i) {
    const auto start = Clock::now();
    work();
    microseconds[i] = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
    progress.update(i + 1, microseconds.size());
  }
  return latency_of(std::move(microseconds));
}

}  // namespace maxlogdet::sim
