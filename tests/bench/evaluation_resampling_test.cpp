// SPDX-License-Identifier: MIT
// Resamples and intervals of an evaluation.
#include "bench/does_it_help/resampling.hpp"

#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet::test {
namespace {

using sim::FrameCounts;

TEST(Resampling, every_resample_has_as_many_frames_of_each_recording_as_it_has) {
  const std::vector<std::size_t> lengths = {1, 4, 0, 37, 300};
  const auto resamples = sim::resample_frames(lengths, 200, 3);
  ASSERT_EQ(resamples.size(), 200U);
  for (const FrameCounts& counts : resamples) {
    ASSERT_EQ(counts.size(), 342U);
    auto first = counts.begin();
    for (const std::size_t length : lengths) {
      const auto end = first + static_cast<std::ptrdiff_t>(length);
      EXPECT_EQ(std::accumulate(first, end, 0U), length);
      first = end;
    }
  }
  EXPECT_EQ(sim::resample_frames(lengths, 200, 3), resamples);
  EXPECT_NE(sim::resample_frames(lengths, 200, 4), resamples);
  EXPECT_NE(resamples[0], resamples[1]);
  EXPECT_TRUE(sim::resample_frames({}, 2, 1)[0].empty());
}

TEST(Resampling, all_frames_are_drawn_equally_often) {
  constexpr std::size_t n = 2000;
  for (const std::size_t length : {5U, 23U, 100U}) {
    FrameCounts sum(length, 0);
    for (const FrameCounts& counts : sim::resample_frames({length}, n, 5)) {
      for (std::size_t f = 0; f < length; ++f) sum[f] += counts[f];
    }
    // Of a resample the count of a frame has a variance of at most 1.
    for (const std::uint32_t count : sum) EXPECT_NEAR(count, n, 5 * std::sqrt(n)) << length;
  }
}

// A resample is a sum of blocks of consecutive frames, in a circle: its counts rise and fall at their ends alone.
TEST(Resampling, blocks_are_of_neighbours) {
  EXPECT_EQ(sim::block_length(1), 1U);
  EXPECT_EQ(sim::block_length(4), 1U);
  EXPECT_EQ(sim::block_length(10), 2U);
  EXPECT_EQ(sim::block_length(50), 10U);
  EXPECT_EQ(sim::block_length(5000), 10U);
  for (const std::size_t length : {12U, 50U, 95U, 400U}) {
    const std::size_t blocks = (length + sim::block_length(length) - 1) / sim::block_length(length);
    for (const FrameCounts& counts : sim::resample_frames({length}, 100, 7)) {
      std::size_t rises = 0;
      for (std::size_t f = 0; f < length; ++f) {
        const std::uint32_t before = counts[(f + length - 1) % length];
        if (counts[f] > before) rises += counts[f] - before;
      }
      EXPECT_LE(rises, blocks);
    }
  }
}

TEST(Resampling, intervals_lie_between_quantiles_if_these_are_known) {
  std::vector<double> values(1001);
  std::iota(values.rbegin(), values.rend(), 0.0);
  EXPECT_NEAR(sim::percentile_interval(values).low, 25, 1e-9);
  EXPECT_NEAR(sim::percentile_interval(values).high, 975, 1e-9);
  EXPECT_TRUE(std::isnan(sim::percentile_interval({}).low));
  EXPECT_TRUE(std::isnan(sim::percentile_interval({}).high));
  EXPECT_TRUE(std::isnan(sim::percentile_interval({1, nan, 2}).low));
  std::vector<double> some_infinite(1000, 1.0);
  for (std::size_t i = 0; i < 100; ++i) some_infinite[i] = infinity;
  const sim::Interval interval = sim::percentile_interval(some_infinite);
  EXPECT_EQ(interval.low, 1);
  EXPECT_EQ(interval.high, infinity);
  EXPECT_EQ(sim::percentile_interval(std::vector<double>(10, infinity)).low, infinity);
}

}  // namespace
}  // namespace maxlogdet::test
