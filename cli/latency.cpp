// SPDX-License-Identifier: MIT
#include "cli/latency.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

namespace maxlogdet::cli {

Latency measure_latency(std::size_t repeat, const std::function<void()>& work) {
  work();
  std::vector<double> times(std::max<std::size_t>(repeat, 1));
  for (double& time : times) {
    const auto start = std::chrono::steady_clock::now();
    work();
    time = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
  }
  std::sort(times.begin(), times.end());
  const auto quantile = [&](double q) {  // nearest rank
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(times.size())));
    return times[std::max<std::size_t>(rank, 1) - 1];
  };
  return {quantile(0.5), quantile(0.99), times.back()};
}

}  // namespace maxlogdet::cli
