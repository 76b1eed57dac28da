// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
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

}  // namespace maxlogdet::sim
