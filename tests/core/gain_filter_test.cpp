// SPDX-License-Identifier: MIT
// What one error bound excludes, in long double: what is below a threshold is below what is assured.
#include "simd/gain_filter.hpp"

#include "tests/support/support.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

double log_uniform(Random& random, double low, double high) { return std::pow(10, random.uniform(low, high)); }

simd::GainFilter random_filter(Random& random) {
  simd::GainFilter line;
  line.slope = 1 + log_uniform(random, -12, 0.5);
  line.offset = log_uniform(random, -36, 2);
  return line;
}

long double at_most(const simd::GainFilter& line, double relative_gain) {
  return static_cast<long double>(line.slope) * relative_gain + line.offset;
}

TEST(GainFilter, excludes_no_candidate_that_may_reach_what_is_assured) {
  TracedRandom random;
  std::size_t above_zero = 0;
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    const simd::GainFilter line = random_filter(random);
    const double assured = line.at_least(log_uniform(random, -30, 12));
    const float threshold = line.survivor_threshold(assured);
    ASSERT_GE(threshold, simd::any_candidate);
    if (threshold < 0) continue;
    ++above_zero;
    ASSERT_LT(at_most(line, std::nextafter(threshold, -1.0F)), assured) << line.slope << ' ' << line.offset;
  }
  EXPECT_GT(above_zero, 0U);
}

// |exact - v| <= 2 error sqrt(1 + v) + relative v + constant: the tangent is nowhere below it, wherever it is taken,
// and close to it where the filter has followed.
TEST(GainFilter, its_tangent_is_above_the_error_and_near_it_where_it_follows) {
  TracedRandom random;
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    simd::GainFilter filter;
    filter.error = log_uniform(random, -12, 0);
    filter.constant = log_uniform(random, -20, 0);
    if (random.chance(0.5)) filter.relative = log_uniform(random, -7, -2);
    filter.take_tangent_at(random.chance(0.1) ? 0 : log_uniform(random, -6, 12));
    const double value = random.chance(0.1) ? 0 : log_uniform(random, -6, 12);
    const auto error = [&] {
      return 2 * static_cast<long double>(filter.error) * std::sqrt(1 + static_cast<long double>(value)) +
             static_cast<long double>(filter.relative) * value + filter.constant;
    };
    ASSERT_GE(at_most(filter, value), (value + error()) * (1 - 1e-14L));
    ASSERT_LE(filter.at_least(value), value - error() + (value + error()) * 1e-14L);
    filter.follow(value);
    ASSERT_GE(at_most(filter, value), (value + error()) * (1 - 1e-14L));
    ASSERT_LE(at_most(filter, value), value + 1.26L * error() + (value + error()) * 1e-14L);
  }
}

TEST(GainFilter, bounds_a_tile_by_its_maximum) {
  TracedRandom random;
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    const simd::GainFilter line = random_filter(random);
    const auto highest = static_cast<float>(log_uniform(random, -30, 12));
    ASSERT_GE(line.line_of_tiles().at(highest), at_most(line, highest)) << line.slope << ' ' << line.offset;
    ASSERT_EQ(line.line_of_tiles().at(-1), -1) << "no candidate remains";
  }
}

TEST(GainFilter, excludes_no_tile_that_may_hold_the_best_in_spite_of_the_drift) {
  TracedRandom random;
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    const double assured = log_uniform(random, -30, 12);
    const double drift = random.chance(0.1) ? 0 : log_uniform(random, -15, 1);
    const float threshold = simd::stale_threshold(assured, drift);
    if (threshold < 0) continue;
    const auto bound = static_cast<long double>(std::nextafter(threshold, -1.0F));
    const long double factor = std::expm1(static_cast<long double>(drift));  // exact gains: (1 + bound) e^drift - 1
    ASSERT_LT(bound + factor + bound * factor, assured) << drift;
  }
  EXPECT_EQ(simd::stale_threshold(-1, 0), simd::any_candidate);
  EXPECT_EQ(simd::stale_threshold(1, std::numeric_limits<double>::infinity()), simd::any_candidate);
}

}  // namespace
}  // namespace maxlogdet::test
