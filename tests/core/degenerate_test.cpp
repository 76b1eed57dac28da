// SPDX-License-Identifier: MIT
// Candidates and requests at and beyond the edges: a valid answer or a named error, from every strategy.
#include "tests/support/answer.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// Every strategy at the edges of what it may be given.
class Degenerate : public ::testing::TestWithParam<Strategy> {
 protected:
  Options asking_for(std::size_t budget) const { return with_budget(budget, GetParam()); }

  // A well-formed answer of that size: see expect_sound; gains that are not negative, a finite log det.
  static void expect_valid(const BlockStore& blocks, const Selection& selection, std::size_t size,
                           double tolerance = infinity, const Matrix6* prior = nullptr) {
    Problem problem = problem_of(blocks, size);
    if (prior != nullptr) problem.set_prior(*prior);
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

// The k lowest indices, where that is the rule of the strategy for candidates that are alike.
std::vector<std::uint32_t> lowest(std::size_t k) {
  std::vector<std::uint32_t> indices(k);
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

TEST_P(Degenerate, budgets_from_none_to_more_than_all) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
  for (const std::size_t budget : {std::size_t{0}, std::size_t{19}, std::size_t{20}, std::size_t{65}, most}) {
    const Selection selection = selector_.select(blocks, asking_for(budget));
    EXPECT_EQ(selection.status, budget < 20 ? Status::ok : Status::all_selected);
    expect_valid(blocks, selection, std::min<std::size_t>(budget, 20), 1e-9);
    EXPECT_EQ(selection.evaluations == 0, budget == 0);
  }
  EXPECT_EQ(Options(-1).budget, 0U);
}

TEST_P(Degenerate, stores_without_a_block_of_any_size) {
  for (const std::size_t size : {0U, 10U}) {
    BlockStore blocks;
    while (blocks.size() < size) blocks.push_back_invalid();
    const Selection selection = selector_.select(blocks, asking_for(5));
    EXPECT_EQ(selection.status, size == 0 ? Status::ok : Status::all_selected);
    EXPECT_EQ(selection.invalid_candidates, size);
    expect_valid(blocks, selection, 0, 1e-9);
    EXPECT_EQ(selector_.select(blocks, asking_for(0)).status, Status::ok);
  }
}

TEST_P(Degenerate, blocks_of_zeros_are_taken_by_lowest_index_and_gain_nothing) {
  const BlockStore blocks =
      store_of(20, [](std::size_t i) { return Block(Block::Zero(1 + static_cast<int>(i) % 3, 6)); });
  const Selection selection = selector_.select(blocks, asking_for(5));
  expect_valid(blocks, selection, 5);
  EXPECT_NEAR(selection.log_det, 6 * std::log(0x1p-26), 1e-9);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(selection.gains[i], 0);
  if (GetParam() != Strategy::stochastic_greedy) {
    EXPECT_EQ(indices_of(selection), lowest(5));
  }
}

TEST_P(Degenerate, identical_blocks) {
  TracedRandom random;
  const BlockStore blocks = copies_of(random_block(random, 2), 40);
  const Selection selection = selector_.select(blocks, asking_for(10));
  expect_valid(blocks, selection, 10, 1e-8);
  if (GetParam() != Strategy::stochastic_greedy) {
    EXPECT_EQ(indices_of(selection), lowest(10));
  }
}

TEST_P(Degenerate, gains_far_below_one_keep_their_digits) {
  // Each gains less than 2^-53, but the later ones a hundred times more than the earlier.
  const BlockStore blocks =
      store_of(10, [](std::size_t i) { return Block((i < 5 ? 1e-12 : 1e-11) * Block::Identity(1, 6)); });
  const Matrix6 information = weak_information();
  const EigenPrior prior(information);
  Options options = asking_for(5);
  options.prior = prior.data();
  options.stochastic.epsilon = 1e-9;  // stochastic_greedy: samples of all that remain
  const Selection selection = selector_.select(blocks, options);
  expect_valid(blocks, selection, 5, infinity, &information);
  EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{5, 6, 7, 8, 9}));
  for (std::size_t i = 0; i < 5; ++i) {
    const double expected = (selection.indices[i] < 5 ? 1e-24 : 1e-22) / 1e-5;
    EXPECT_NEAR(selection.gains[i], expected, expected / 10);
  }
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

TEST_P(Degenerate, extreme_blocks_and_priors) {
  TracedRandom random;
  const BlockStore extreme = store_of(60, [&](std::size_t i) {
    return random_block(random, 3, i < 30 ? 3.4e38 : 1e-38);  // denormals among them
  });
  const BlockStore usual = random_store(random, 60);
  std::vector<Matrix6> priors;
  for (const double size : {1e-20, 1e-5, 1e20, 1e300}) priors.emplace_back(size * Matrix6::Identity());
  priors.emplace_back(Matrix6::Zero());
  for (int i = 0; i < 6; ++i) priors.back()(i, i) = std::pow(10.0, 4 * i - 10);
  priors.push_back(random_prior(random));  // asymmetric by rounding only
  priors.back()(0, 5) *= 1 + 1e-15;
  for (const BlockStore* const blocks : {&extreme, &usual}) {
    Options options = asking_for(20);
    expect_valid(*blocks, selector_.select(*blocks, options), 20);
    for (const Matrix6& information : priors) {
      const EigenPrior prior(information);
      options.prior = prior.data();
      expect_valid(*blocks, selector_.select(*blocks, options), 20, infinity, &information);
    }
  }
}

TEST_P(Degenerate, more_candidates_than_capacity) {
  Random random;
  const BlockStore blocks = random_store(random, 65);
  expect_error(selector_.select(blocks, asking_for(10)), Error::capacity_exceeded);
  Selector none(0);
  expect_error(none.select(blocks, asking_for(0)), Error::capacity_exceeded);
}

TEST_P(Degenerate, capacity_beyond_what_an_index_can_count) {
  EXPECT_THROW(Selector{std::size_t{1} << 32U}, std::bad_alloc);
  EXPECT_THROW(Selector{std::numeric_limits<std::size_t>::max()}, std::bad_alloc);
}

TEST_P(Degenerate, epsilon_at_and_beyond_its_ends) {
  Random random;
  const BlockStore blocks = random_store(random, 40);
  Options options = asking_for(10);
  for (const double epsilon : {0.0, 1.0, -0.1, 1.1, nan, infinity, -infinity}) {
    options.stochastic.epsilon = epsilon;
    const Selection selection = selector_.select(blocks, options);
    if (GetParam() == Strategy::stochastic_greedy) {
      expect_error(selection, Error::invalid_epsilon);
    } else {
      expect_valid(blocks, selection, 10);
    }
  }
  for (const double epsilon : {std::numeric_limits<double>::denorm_min(), 1e-300, 0.5, std::nextafter(1.0, 0.0)}) {
    options.stochastic.epsilon = epsilon;
    expect_valid(blocks, selector_.select(blocks, options), 10);
  }
}

TEST_P(Degenerate, unknown_strategy_and_time_limit) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  Options options = asking_for(5);
  for (const double limit : {-1.0, nan, -infinity}) {
    options.time_limit = limit;
    expect_error(selector_.select(blocks, options), Error::invalid_time_limit);
  }
  options.time_limit = infinity;
  expect_valid(blocks, selector_.select(blocks, options), 5);
  options.strategy = static_cast<Strategy>(1234);
  expect_error(selector_.select(blocks, options), Error::invalid_strategy);
}

// As many candidates as without a limit, and what was searched is a prefix of the full answer; on one thread and on
// two.
TEST_P(Degenerate, deadline_fills_the_budget) {
  PoolExecutor pool(1);
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::clustered, 10000, 5), block_kinds[3]);
  Selector selector(10000, &pool);
  for (const int threads : {1, 2}) {
    SCOPED_TRACE(std::to_string(threads) + " threads");
    Options options = asking_for(150);
    options.threads = threads;
    const Selection whole = selector.select(blocks, options);
    const double log_det = whole.log_det;
    const Answer full(whole);
    ASSERT_EQ(full.reason, "ok");
    bool was_cut = false;
    for (double limit = 1e-9; limit < 1e-2; limit = std::max(1e-6, 1.5 * limit)) {
      options.time_limit = limit;
      const Selection selection = selector.select(blocks, options);
      expect_valid(blocks, selection, 150, 1e-8);
      EXPECT_LE(selection.log_det, log_det + 0.1);
      if (selection.status == Status::ok) {
        EXPECT_EQ(indices_of(selection), full.indices);
        continue;
      }
      EXPECT_EQ(selection.status, Status::deadline_reached);
      was_cut = true;
      EXPECT_LT(selection.searched, 150U);
      EXPECT_TRUE(std::equal(selection.begin(), selection.begin() + selection.searched, full.indices.begin()));
    }
    EXPECT_TRUE(was_cut) << "1 ns is not enough for anything";
  }
}

TEST_P(Degenerate, a_moved_selector_keeps_working_and_the_empty_one_says_so) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  Selector first(20);
  const auto before = indices_of(first.select(blocks, asking_for(5)));
  Selector second(std::move(first));
  EXPECT_EQ(indices_of(second.select(blocks, asking_for(5))), before);
  EXPECT_EQ(second.capacity(), 20U);
  first = Selector(1);
  expect_error(first.select(blocks, asking_for(1)), Error::capacity_exceeded);
  EXPECT_EQ(first.capacity(), 1U);
  Selector third = std::move(first);
  // NOLINTNEXTLINE(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  expect_error(first.select(BlockStore(), asking_for(0)), Error::capacity_exceeded);
  // NOLINTNEXTLINE(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  expect_error(first.select(blocks, asking_for(1)), Error::capacity_exceeded);
}

INSTANTIATE_TEST_SUITE_P(, Degenerate, ::testing::ValuesIn(strategies),
                         [](const auto& parameter) { return std::string(to_string(parameter.param)); });

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
    if (GetParam() != Strategy::stochastic_greedy) {
      EXPECT_LE(gain_given_away(blocks, indices_of(selection)), 1e-9);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
