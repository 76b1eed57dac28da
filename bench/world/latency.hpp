// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Wall times of single calls, us.
struct Latency {
  double median = 0;
  double p99 = 0;
  double max = 0;
  double p999 = 0;  ///< 99.9 %
};

/// Returns nearest-rank quantiles of the times of single calls; at least one.
Latency latency_of(std::vector<double> microseconds);

/// Calls `work` once to warm up, and times each of `repeat` further calls (at least one). After two seconds the
/// progress is shown on stderr, if that is a terminal, under the name `what`.
Latency measure_latency(const std::string& what, std::size_t repeat, const std::function<void()>& work);

}  // namespace maxlogdet::sim
