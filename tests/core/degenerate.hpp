// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

namespace maxlogdet::test {

/// Whether a strategy looks at every candidate in every round, or answers as if it did: then it takes equal candidates
/// by lowest index.
inline bool looks_at_all(Strategy strategy) {
  constexpr Strategy known[] = {Strategy::greedy, Strategy::lazy_greedy, Strategy::relaxed, Strategy::backward_greedy,
                                Strategy::automatic};
  return std::find(std::begin(known), std::end(known), strategy) != std::end(known);
}

/// Every strategy at the edges of what it may be given.
class Degenerate : public ::testing::TestWithParam<Strategy> {
 protected:
  Options asking_for(std::size_t budget) const { return with_budget(budget, GetParam()); }

  // A well-formed answer: distinct indices of valid candidates, gains that are not negative, a finite log det.
  static void expect_valid(const BlockStore& blocks, const Selection& selection, std::size_t size) {
    ASSERT_TRUE(selection.has_answer()) << to_string(selection.status);
    ASSERT_EQ(selection.size, size);
    const std::set<std::uint32_t> distinct(selection.begin(), selection.end());
    EXPECT_EQ(distinct.size(), size);
    for (const std::uint32_t index : selection) {
      ASSERT_LT(index, blocks.size());
      EXPECT_TRUE(blocks.is_valid(index));
    }
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

inline BlockStore random_store(Random& random, std::size_t n) {
  BlockStore blocks;
  for (std::size_t i = 0; i < n; ++i) push_back(blocks, random_block(random, 2));
  return blocks;
}

}  // namespace maxlogdet::test
