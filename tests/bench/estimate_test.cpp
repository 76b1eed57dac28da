// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maxlogdet::test {
namespace {

using sim::Estimate;

TEST(Estimate, of_a_mean_is_as_computed_by_hand) {
  const Estimate two = sim::mean_of({1, 2});
  EXPECT_DOUBLE_EQ(two.value, 1.5);
  EXPECT_NEAR(two.ci95, 6.3531, 1e-4) << "12.7062 / 2";
  const Estimate one = sim::mean_of({7});
  EXPECT_TRUE(std::isnan(one.ci95)) << "one value has no interval";
  EXPECT_STREQ(sim::verdict(one), "open");
  const Estimate ten = sim::mean_of({1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  EXPECT_DOUBLE_EQ(ten.value, 5.5);
  EXPECT_NEAR(ten.ci95, 2.16587, 1e-4) << "2.2622 * 3.02765 / sqrt(10)";
}

}  // namespace
}  // namespace maxlogdet::test
