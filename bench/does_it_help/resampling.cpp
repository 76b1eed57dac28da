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

void SortedValues::sort() { std::sort(values_.begin(), values_.end()); }

double SortedValues::quantile(double q) const {
  if (values_.empty()) return nan;
  const double rank = std::ceil(q * static_cast<double>(values_.size()));
  return values_[static_cast<std::size_t>(std::max(rank, 1.0)) - 1].first;
}

double SortedValues::quantile(double q, const FrameCounts& counts) const {
  std::uint64_t all = 0;
  for (const auto& [value, frame] : values_) all += counts[frame];
  const double rank = std::max(std::ceil(q * static_cast<double>(all)), 1.0);
  std::uint64_t below = 0;
  for (const auto& [value, frame] : values_) {
    below += counts[frame];
    if (static_cast<double>(below) >= rank) return value;
  }
  return nan;
}

std::vector<double> SortedValues::quantiles(double q, const std::vector<FrameCounts>& resamples) const {
  std::vector<double> values;
  values.reserve(resamples.size());
  for (const FrameCounts& counts : resamples) values.push_back(quantile(q, counts));
  return values;
}

Interval interval_of_ratio(const SortedValues& ours, const SortedValues& theirs,
                           const std::vector<FrameCounts>& resamples) {
  std::vector<double> ratios = ours.quantiles(0.5, resamples);
  const std::vector<double> divisors = theirs.quantiles(0.5, resamples);
  for (std::size_t r = 0; r < ratios.size(); ++r) ratios[r] /= divisors[r];
  return percentile_interval(std::move(ratios));
}

}  // namespace maxlogdet::sim
