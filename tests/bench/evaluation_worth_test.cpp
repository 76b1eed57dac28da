// SPDX-License-Identifier: MIT
// How many matches of a reference give the pose that a selection gives.
#include "bench/does_it_help/evaluation.hpp"

#include "tests/support/numbers.hpp"
#include "tests/support/traced_random.hpp"

namespace maxlogdet::test {
namespace {

using sim::matches_worth;

double curve_at(double m, double all) { return 1 / m - 1 / all; }

TEST(MatchesWorth, is_exact_where_deviations_follow_the_model) {
  const std::vector<std::size_t> counts = {15, 20, 33, 60, 61, 200, 400};
  std::vector<double> values;
  for (const std::size_t count : counts) values.push_back(7 * curve_at(static_cast<double>(count), 400));
  for (double m = 15; m <= 400; m += 0.7) EXPECT_NEAR(matches_worth(counts, values, 7 * curve_at(m, 400)), m, 1e-8 * m);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    EXPECT_NEAR(matches_worth(counts, values, values[i]), static_cast<double>(counts[i]), 1e-9);
  }
}

TEST(MatchesWorth, of_values_that_rise_again_the_first_count_that_reaches_the_target_decides) {
  EXPECT_NEAR(matches_worth({10, 20, 30, 40}, {4, 2, 3, 1}, 2), 20, 1e-9);
  EXPECT_GT(matches_worth({10, 20, 30, 40}, {4, 2, 3, 1}, 1.9), 30);
}

// Too few matches give no pose: their median deviation is infinite.
TEST(MatchesWorth, infinite_deviations_are_above_every_target) {
  const std::vector<std::size_t> counts = {6, 10, 20, 40};
  const std::vector<double> values = {infinity, infinity, 2, 1};
  EXPECT_EQ(matches_worth(counts, values, 3), 20) << "no more is known than that these suffice";
  EXPECT_EQ(matches_worth(counts, values, 2), 20);
  EXPECT_GT(matches_worth(counts, values, 1.5), 20);
  EXPECT_EQ(matches_worth(counts, values, infinity), 6);
}

}  // namespace
}  // namespace maxlogdet::test
