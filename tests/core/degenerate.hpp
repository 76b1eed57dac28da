// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"

#include <cmath>

namespace maxlogdet::test {

/// Whether a strategy looks at every candidate in every round, or answers as if it did: then it takes equal candidates
/// by lowest index.
inline bool looks_at_all(Strategy strategy) { return strategy != Strategy::stochastic_greedy; }

/// Every strategy at the edges of what it may be given.
class Degenerate : public ::testing::TestWithParam<Strategy> {
 protected:
  Options asking_for(std::size_t budget) const { return with_budget(budget, GetParam()); }

  // A well-formed answer of that size: see expect_sound; gains that are not negative, a finite log det.
  static void expect_valid(const BlockStore& blocks, const Selection& selection, std::size_t size,
                           double tolerance = infinity, const Matrix6& prior = default_information()) {
    Problem problem = problem_of(blocks, size);
    problem.set_prior(prior);
    expect_sound(problem, selection, tolerance);
    ASSERT_EQ(selection.size, size);
    EXPECT_TRUE(std::isfinite(selection.log_det));
    for (std::size_t i = 0; i < size; ++i) EXPECT_GE(selection.gains[i], 0);
  }

  static void expect_error(const Selection& selection, Error error) {
    EXPECT_EQ(selection.error, error) << selection.reason();
    EXPECT_EQ(selection.status, Status::error);
    EXPECT_FALSE(selection.has_answer());
    EXPECT_EQ(selection.size, 0U);
    EXPECT_TRUE(std::isnan(selection.log_det));
  }

  Selector selector_{64};
};

}  // namespace maxlogdet::test
