// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>

namespace maxlogdet::cli {

/// Wall time of one call, us.
struct Latency {
  double median = 0;
  double p99 = 0;
  double max = 0;
};

/// Calls `work` once to warm up and then `repeat` times (at least once), each timed by itself.
Latency measure_latency(std::size_t repeat, const std::function<void()>& work);

}  // namespace maxlogdet::cli
