// SPDX-License-Identifier: MIT
#include "bench/does_it_help/resampling.hpp"

#include "bench/world/draws.hpp"
#include "bench/world/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Interval percentile_interval(std::vector<double> values) {
  const bool has_nan = std::any_of(values.begin(), values.end(), [](double value) { return std::isnan(value); });
  if (values.empty() || has_nan) return {nan, nan};
  return {quantile_of(values, 0.025), quantile_of(values, 0.975)};
}

std::size_t block_length(std::size_t frames) { return std::clamp<std::size_t>(frames / 5, 1, 10); }

std::vector<FrameCounts> resample_frames(const std::vector<std::size_t>& lengths, std::size_t resamples,
                                         std::uint64_t seed) {
  std::size_t frames = 0;
  for (const std::size_t length : lengths) frames += length;
  std::vector<FrameCounts> all(resamples, FrameCounts(frames, 0));
  for (std::size_t r = 0; r < resamples; ++r) {
    Draws draws(seed, r);
    std::size_t first = 0;
    for (const std::size_t length : lengths) {
      const std::size_t block = block_length(length);
      for (std::size_t drawn = 0; drawn < length;) {
        const std::size_t start = draws.below(length);
        for (std::size_t i = 0; i < block && drawn < length; ++i, ++drawn) ++all[r][first + (start + i) % length];
      }
      first += length;
    }
  }
  return all;
}

}  // namespace maxlogdet::sim
