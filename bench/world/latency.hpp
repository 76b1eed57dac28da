// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::sim {

/// Wall times of single calls, us.
struct Latency {
  double median = 0;
  double p99 = 0;
  double max = 0;
};

/// Returns nearest-rank quantiles of the times of single calls; at least one.
inline Latency latency_of(std::vector<double> microseconds) {
  std::sort(microseconds.begin(), microseconds.end());
  const auto quantile = [&](double q) {
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(microseconds.size())));
    return microseconds[std::max<std::size_t>(rank, 1) - 1];
  };
  return {quantile(0.5), quantile(0.99), microseconds.back()};
}

/// Returns the wall time of one call, us.
template <class Work>
double microseconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// Calls `work` once to warm up, and times each of `repeat` further calls (at least one). After two seconds the
/// progress is shown on stderr, if that is a terminal, under the name `what`.
template <class Work>
Latency measure_latency(const std::string& what, std::size_t repeat, const Work& work) {
  work();
  std::vector<double> microseconds(std::max<std::size_t>(repeat, 1));
  Progress progress(what, "call");
  for (std::size_t i = 0; i < microseconds.size(); ++i) {
    microseconds[i] = microseconds_of(work);
    progress.update(i + 1, microseconds.size());
  }
  return latency_of(std::move(microseconds));
}

}  // namespace maxlogdet::sim
