// SPDX-License-Identifier: MIT
#include "bench/world/statistics.hpp"

#include <algorithm>
#include <cstddef>

namespace maxlogdet::sim {

double quantile_of(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double share = at - static_cast<double>(below);
  if (share == 0 || values[below] == values[above]) return values[below];  // also of infinite ones
  return values[below] + share * (values[above] - values[below]);
}

}  // namespace maxlogdet::sim
