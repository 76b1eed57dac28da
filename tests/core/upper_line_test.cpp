// SPDX-License-Identifier: MIT
// What one error bound excludes, in long double: what is below a threshold is below what is assured.
#include "simd/upper_line.hpp"

#include "tests/support/support.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

double log_uniform(Random& random, double low, double high) { return std::pow(10, random.uniform(low, high)); }

simd::UpperLine random_line(Random& random) {
  simd::UpperLine line;
  line.slope = 1 + log_uniform(random, -12, 0.5);
  line.offset = log_uniform(random, -36, 2);
  return line;
}

long double exact_maximum(const simd::UpperLine& line, float relative_gain) {
  return static_cast<long double>(line.slope) * relative_gain + line.offset;
}

TEST(UpperLine, excludes_no_candidate_that_may_reach_what_is_assured) {
  Random random;
  SCOPED_TRACE(random.name());
  std::size_t above_zero = 0;
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    const simd::UpperLine line = random_line(random);
    const double assured = line.at_least(log_uniform(random, -30, 12));
    const float threshold = line.survivor_threshold(assured);
    ASSERT_GE(threshold, simd::any_candidate);
    if (threshold < 0) continue;
    ++above_zero;
    ASSERT_LT(exact_maximum(line, simd::next_below(threshold)), assured) << line.slope << ' ' << line.offset;
  }
  EXPECT_GT(above_zero, 0U);
}

TEST(UpperLine, bounds_a_tile_by_its_maximum) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    const simd::UpperLine line = random_line(random);
    const auto highest = static_cast<float>(log_uniform(random, -30, 12));
    ASSERT_GE(rounded_up(line).at(highest), exact_maximum(line, highest)) << line.slope << ' ' << line.offset;
    ASSERT_EQ(rounded_up(line).at(-1), -1) << "no candidate remains";
  }
}

TEST(UpperLine, excludes_no_tile_that_may_hold_the_best_in_spite_of_the_drift) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    const double assured = log_uniform(random, -30, 12);
    const double drift = random.chance(0.1) ? 0 : log_uniform(random, -15, 1);
    const float threshold = simd::stale_threshold(assured, drift);
    if (threshold < 0) continue;
    const auto bound = static_cast<long double>(simd::next_below(threshold));
    const long double factor = std::expm1(static_cast<long double>(drift));  // exact gains: (1 + bound) e^drift - 1
    ASSERT_LT(bound + factor + bound * factor, assured) << drift;
  }
  EXPECT_EQ(simd::stale_threshold(-1, 0), simd::any_candidate);
  EXPECT_EQ(simd::stale_threshold(1, std::numeric_limits<double>::infinity()), simd::any_candidate);
}

TEST(UpperLine, the_next_float_below_is_that_of_the_standard_library) {
  Random random;
  SCOPED_TRACE(random.name());
  using Limits = std::numeric_limits<float>;
  const auto check = [](float value) {
    EXPECT_EQ(simd::next_below(value), std::nextafter(value, -Limits::infinity())) << value;
  };
  for (const float value : {0.0F, -0.0F, Limits::denorm_min(), -Limits::denorm_min(), Limits::min(), -Limits::min(),
                            Limits::max(), Limits::lowest(), Limits::infinity(), -Limits::infinity(), 1.0F, -0.5F}) {
    check(value);
  }
  for (std::size_t trial = trials(10000); trial > 0; --trial) {
    check(static_cast<float>((random.chance(0.5) ? 1 : -1) * log_uniform(random, -45, 38)));
  }
}

}  // namespace
}  // namespace maxlogdet::test
