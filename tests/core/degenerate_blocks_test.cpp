// SPDX-License-Identifier: MIT
// Candidates at and beyond the edges: a valid answer from every strategy.
#include "tests/core/degenerate.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace maxlogdet::test {
namespace {

const double default_prior_log_det = 6 * std::log(1e-5);

TEST_P(Degenerate, no_candidates_or_no_budget) {
  Random random;
  for (const BlockStore& blocks : {BlockStore(), random_store(random, 20)}) {
    const Selection selection = selector_.select(blocks, asking_for(blocks.size() == 0 ? 10 : 0));
    EXPECT_EQ(selection.status, Status::ok);
    expect_valid(blocks, selection, 0);
    EXPECT_NEAR(selection.log_det, default_prior_log_det, 1e-9);
    EXPECT_EQ(selection.evaluations, 0U);
  }
}

TEST_P(Degenerate, budget_of_all_and_more_selects_everything) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  for (const std::size_t budget :
       {std::size_t{20}, std::size_t{21}, std::size_t{64}, std::size_t{65}, std::numeric_limits<std::size_t>::max()}) {
    const Selection selection = selector_.select(blocks, asking_for(budget));
    EXPECT_EQ(selection.status, Status::all_selected);
    expect_valid(blocks, selection, 20, 1e-9);
  }
  EXPECT_EQ(selector_.select(blocks, asking_for(19)).status, Status::ok);
  EXPECT_EQ(Options(-1).budget, 0U);
}

TEST_P(Degenerate, blocks_of_zeros_are_taken_by_lowest_index_and_gain_nothing) {
  const BlockStore blocks =
      store_of(20, [](std::size_t i) { return Block(Block::Zero(1 + static_cast<int>(i) % 3, 6)); });
  const Selection selection = selector_.select(blocks, asking_for(5));
  expect_valid(blocks, selection, 5);
  EXPECT_NEAR(selection.log_det, default_prior_log_det, 1e-9);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(selection.gains[i], 0);
  if (looks_at_all(GetParam())) {
    EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
  }
}

TEST_P(Degenerate, identical_blocks) {
  TracedRandom random;
  const BlockStore blocks = copies_of(random_block(random, 2), 40);
  const Selection selection = selector_.select(blocks, asking_for(10));
  expect_valid(blocks, selection, 10, 1e-8);
  if (looks_at_all(GetParam())) {
    EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  }
}

TEST_P(Degenerate, one_direction_unobservable) {
  for (int direction = 0; direction < 6; ++direction) {
    TracedRandom random(static_cast<std::uint64_t>(direction));
    const BlockStore blocks = store_of(50, [&](std::size_t) {
      Block block = random_block(random, random.integer(1, 3));
      block.col(direction).setZero();
      return block;
    });
    const Selection selection = selector_.select(blocks, asking_for(20));
    expect_valid(blocks, selection, 20, 1e-8);
    if (GetParam() == Strategy::greedy || GetParam() == Strategy::lazy_greedy) {
      EXPECT_LE(gain_given_away(blocks, indices_of(selection)), 1e-9);
    }
  }
}

TEST_P(Degenerate, scales_from_1e_minus_12_to_1e12) {
  for_each_exponent(-12, 12, [&](Random& random, int exponent) {
    const BlockStore blocks = random_store(random, 50, std::pow(10.0, exponent));
    const Selection selection = selector_.select(blocks, asking_for(20));
    expect_valid(blocks, selection, 20);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-6);
  });
}

TEST_P(Degenerate, gains_far_below_one_keep_their_digits) {
  // Each gains less than 2^-53, but the later ones a hundred times more than the earlier.
  const BlockStore blocks =
      store_of(10, [](std::size_t i) { return Block((i < 5 ? 1e-12 : 1e-11) * Block::Identity(1, 6)); });
  Options options = asking_for(5);
  options.stochastic.epsilon = 1e-9;  // stochastic_greedy: samples of all that remain
  const Selection selection = selector_.select(blocks, options);
  expect_valid(blocks, selection, 5);
  if (looks_at_all(GetParam()) || GetParam() == Strategy::stochastic_greedy) {
    EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{5, 6, 7, 8, 9}));
  }
  for (std::size_t i = 0; i < 5; ++i) {
    const double expected = (selection.indices[i] < 5 ? 1e-24 : 1e-22) / 1e-5;
    EXPECT_NEAR(selection.gains[i], expected, expected / 10);
  }
}

TEST_P(Degenerate, scales_mixed_in_one_store) {
  TracedRandom random;
  const BlockStore blocks = store_of(60, [&](std::size_t) {
    return random_block(random, random.integer(1, 3), std::pow(10.0, random.integer(-12, 12)));
  });
  expect_valid(blocks, selector_.select(blocks, asking_for(30)), 30);
}

TEST_P(Degenerate, blocks_that_float32_cannot_hold_are_counted_and_never_selected) {
  TracedRandom random;
  BlockStore blocks;
  std::size_t invalid = 0;
  for (int i = 0; i < 60; ++i) {
    Block block = random_block(random, random.integer(1, 3));
    const double bad[] = {nan, infinity, -infinity, 1e39, -1e300};
    if (i % 3 == 0) {
      block(random.integer(0, static_cast<int>(block.rows()) - 1), random.integer(0, 5)) = bad[i / 3 % 5];
      ++invalid;
    }
    EXPECT_EQ(push_back(blocks, block), static_cast<std::size_t>(i));
  }
  Selection selection = selector_.select(blocks, asking_for(30));
  EXPECT_EQ(selection.invalid_candidates, invalid);
  expect_valid(blocks, selection, 30);
  selection = selector_.select(blocks, asking_for(50));
  EXPECT_EQ(selection.status, Status::all_selected);
  expect_valid(blocks, selection, 60 - invalid);
}

TEST_P(Degenerate, nothing_but_invalid_blocks) {
  BlockStore blocks;
  for (int i = 0; i < 10; ++i) blocks.push_back_invalid();
  const Selection selection = selector_.select(blocks, asking_for(5));
  EXPECT_EQ(selection.status, Status::all_selected);
  EXPECT_EQ(selection.invalid_candidates, 10U);
  expect_valid(blocks, selection, 0);
  EXPECT_EQ(selector_.select(blocks, asking_for(0)).status, Status::ok);
}

TEST_P(Degenerate, extreme_values_that_float32_can_hold) {
  TracedRandom random;
  const BlockStore blocks = store_of(60, [&](std::size_t i) {
    return random_block(random, 3, i < 30 ? 3.4e38 : 1e-38);  // denormals among them
  });
  const Matrix6 smallest = 1e-20 * Matrix6::Identity();
  const EigenPrior prior(smallest);
  Options options = asking_for(20);
  expect_valid(blocks, selector_.select(blocks, options), 20);
  options.prior = prior.data();
  expect_valid(blocks, selector_.select(blocks, options), 20);
}

}  // namespace
}  // namespace maxlogdet::test
