// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Wall time of one call, us.
struct Latency {
  double median = 0;
  double p99 = 0;
  double max = 0;
  double p999 = 0;  ///< 99.9 %
};

/// Nearest-rank quantiles of the times of single calls, us; at least one.
Latency latency_of(std::vector<double> microseconds);

/// Calls `work` once to warm up and then `repeat` times (at least once), each timed by itself. What takes over two
/// seconds shows its progress on stderr, under the name of `what`, when that is a terminal.
Latency measure_latency(const std::string& what, std::size_t repeat, const std::function<void()>& work);

}  // namespace maxlogdet::sim
