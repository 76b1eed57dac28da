// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace maxlogdet::sim {

/// The 95 % interval of a statistic.
struct Interval {
  double low = 0;
  double high = 0;
};

/// Returns the interval between the quantiles 0.025 and 0.975 of a statistic's values over resamples; NaN where a value
/// is NaN, or there is none.
Interval percentile_interval(std::vector<double> values);

/// How often each frame is in a resample.
using FrameCounts = std::vector<std::uint32_t>;

/// Returns resamples of the frames by the circular block bootstrap (Politis & Romano 1992): blocks of neighbouring
/// frames are drawn with replacement from each recording until it has its length again, because neighbours have matches
/// in common. `lengths`: the number of frames of each recording, whose frames are numbered one after the other.
std::vector<FrameCounts> resample_frames(const std::vector<std::size_t>& lengths, std::size_t resamples,
                                         std::uint64_t seed);

/// The length of these blocks: ten frames, a second of many recordings, or a fifth of a short recording.
std::size_t block_length(std::size_t frames);

/// Values of frames, any number of each, sorted once so that quantiles of resamples are cheap.
class SortedValues {
 public:
  void add(double value, std::uint32_t frame) { values_.emplace_back(value, frame); }
  /// Call once, after the last value.
  void sort();
  std::size_t size() const { return values_.size(); }

  /// Returns the quantile of all values, or of those of a resample (the smallest that a share q does not exceed); NaN
  /// without values.
  double quantile(double q) const;
  double quantile(double q, const FrameCounts& counts) const;

  /// Returns the intervals's values: the quantile of every resample.
  std::vector<double> quantiles(double q, const std::vector<FrameCounts>& resamples) const;

 private:
  std::vector<std::pair<double, std::uint32_t>> values_;
};

/// Returns the interval of the ratio of two medians, `ours` to `theirs`, in the same resamples.
Interval interval_of_ratio(const SortedValues& ours, const SortedValues& theirs,
                           const std::vector<FrameCounts>& resamples);

}  // namespace maxlogdet::sim
