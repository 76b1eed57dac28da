// SPDX-License-Identifier: MIT
// Input at and beyond the edges: a valid answer or a named status, for every strategy.
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <set>

namespace maxlogdet::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// Whether it is known to look at every candidate in every round, or to answer as if it did: then equal candidates are
// taken by lowest index.
bool looks_at_all(Strategy strategy) {
  constexpr Strategy known[] = {Strategy::greedy, Strategy::lazy_greedy, Strategy::relaxed, Strategy::backward_greedy,
                                Strategy::automatic};
  return std::find(std::begin(known), std::end(known), strategy) != std::end(known);
}

class Degenerate : public ::testing::TestWithParam<Strategy> {
 protected:
  Options with_budget(std::size_t budget) const {
    Options options;
    options.strategy = GetParam();
    options.budget = budget;
    return options;
  }

  // An answer that is well formed: distinct indices of valid candidates, gains and log det that belong to them.
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

  static void expect_error(const Selection& selection, Status status) {
    EXPECT_EQ(selection.status, status) << to_string(selection.status);
    EXPECT_FALSE(selection.has_answer());
    EXPECT_EQ(selection.size, 0U);
    EXPECT_TRUE(std::isnan(selection.log_det));
  }

  Selector selector_{64};
};

BlockStore random_blocks(Random& random, std::size_t n, int rows = 2) {
  BlockStore blocks;
  for (std::size_t i = 0; i < n; ++i) push_back(blocks, random_block(random, rows));
  return blocks;
}

const double default_prior_log_det = 6 * std::log(1e-5);

TEST_P(Degenerate, no_candidates) {
  const BlockStore blocks;
  const Selection selection = selector_.select(blocks, with_budget(10));
  EXPECT_EQ(selection.status, Status::ok);
  expect_valid(blocks, selection, 0);
  EXPECT_NEAR(selection.log_det, default_prior_log_det, 1e-9);
  EXPECT_EQ(selection.evaluations, 0U);
}

TEST_P(Degenerate, budget_of_zero) {
  Random random;
  const BlockStore blocks = random_blocks(random, 20);
  const Selection selection = selector_.select(blocks, with_budget(0));
  EXPECT_EQ(selection.status, Status::ok);
  expect_valid(blocks, selection, 0);
  EXPECT_NEAR(selection.log_det, default_prior_log_det, 1e-9);
}

TEST_P(Degenerate, budget_of_all_and_more_selects_everything) {
  Random random;
  const BlockStore blocks = random_blocks(random, 20);
  for (const std::size_t budget : {20U, 21U, 64U}) {
    const Selection selection = selector_.select(blocks, with_budget(budget));
    EXPECT_EQ(selection.status, Status::all_selected);
    expect_valid(blocks, selection, 20);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-9);
  }
  EXPECT_EQ(selector_.select(blocks, with_budget(19)).status, Status::ok);
}

TEST_P(Degenerate, blocks_of_zeros_are_taken_by_lowest_index_and_gain_nothing) {
  BlockStore blocks;
  for (int i = 0; i < 20; ++i) push_back(blocks, Block::Zero(1 + i % 3, 6));
  const Selection selection = selector_.select(blocks, with_budget(5));
  expect_valid(blocks, selection, 5);
  EXPECT_NEAR(selection.log_det, default_prior_log_det, 1e-9);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(selection.gains[i], 0);
  if (looks_at_all(GetParam())) {
    EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
  }
}

TEST_P(Degenerate, identical_blocks) {
  Random random;
  SCOPED_TRACE(random.name());
  const Block block = random_block(random, 2);
  BlockStore blocks;
  for (int i = 0; i < 40; ++i) push_back(blocks, block);
  const Selection selection = selector_.select(blocks, with_budget(10));
  expect_valid(blocks, selection, 10);
  EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8);
  if (looks_at_all(GetParam())) {
    EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  }
}

TEST_P(Degenerate, one_direction_unobservable) {
  for (int direction = 0; direction < 6; ++direction) {
    Random random(static_cast<std::uint64_t>(direction));
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    for (int i = 0; i < 50; ++i) {
      Block block = random_block(random, random.integer(1, 3));
      block.col(direction).setZero();
      push_back(blocks, block);
    }
    const Selection selection = selector_.select(blocks, with_budget(20));
    expect_valid(blocks, selection, 20);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8);
    if (GetParam() == Strategy::greedy || GetParam() == Strategy::lazy_greedy) {
      EXPECT_LE(gain_given_away(blocks, indices_of(selection)), 1e-9);
    }
  }
}

TEST_P(Degenerate, scales_from_1e_minus_12_to_1e12) {
  for (int exponent = -12; exponent <= 12; ++exponent) {
    Random random(static_cast<std::uint64_t>(exponent + 12));
    SCOPED_TRACE(random.name() + ", scale 1e" + std::to_string(exponent));
    const double scale = std::pow(10.0, exponent);
    BlockStore blocks;
    for (int i = 0; i < 50; ++i) push_back(blocks, random_block(random, random.integer(1, 3), scale));
    const Selection selection = selector_.select(blocks, with_budget(20));
    expect_valid(blocks, selection, 20);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-6);
  }
}

TEST_P(Degenerate, gains_far_below_one_keep_their_digits) {
  BlockStore blocks;  // each gains less than 2^-53, but the later ones a hundred times more than the earlier
  for (const double size : {1e-12, 1e-11}) {
    for (int i = 0; i < 5; ++i) push_back(blocks, size * Block::Identity(1, 6));
  }
  Options options = with_budget(5);
  options.epsilon = 1e-9;  // stochastic_greedy: samples of all that remain
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
  Random random;
  SCOPED_TRACE(random.name());
  BlockStore blocks;
  for (int i = 0; i < 60; ++i) {
    push_back(blocks, random_block(random, random.integer(1, 3), std::pow(10.0, random.integer(-12, 12))));
  }
  expect_valid(blocks, selector_.select(blocks, with_budget(30)), 30);
}

TEST_P(Degenerate, blocks_that_float32_cannot_hold_are_counted_and_never_selected) {
  Random random;
  SCOPED_TRACE(random.name());
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
  Selection selection = selector_.select(blocks, with_budget(30));
  EXPECT_EQ(selection.invalid_candidates, invalid);
  expect_valid(blocks, selection, 30);
  selection = selector_.select(blocks, with_budget(50));
  EXPECT_EQ(selection.status, Status::all_selected);
  expect_valid(blocks, selection, 60 - invalid);
}

TEST_P(Degenerate, nothing_but_invalid_blocks) {
  BlockStore blocks;
  for (int i = 0; i < 10; ++i) blocks.push_back_invalid();
  const Selection selection = selector_.select(blocks, with_budget(5));
  EXPECT_EQ(selection.status, Status::all_selected);
  EXPECT_EQ(selection.invalid_candidates, 10U);
  expect_valid(blocks, selection, 0);
  EXPECT_EQ(selector_.select(blocks, with_budget(0)).status, Status::ok);
}

TEST_P(Degenerate, extreme_values_that_float32_can_hold) {
  Random random;
  SCOPED_TRACE(random.name());
  BlockStore blocks;
  for (int i = 0; i < 30; ++i) push_back(blocks, random_block(random, 3, 3.4e38));
  for (int i = 0; i < 30; ++i) push_back(blocks, random_block(random, 3, 1e-38));  // denormals among them
  const Matrix6 smallest = 1e-20 * Matrix6::Identity();
  const EigenPrior prior(smallest);
  Options options = with_budget(20);
  expect_valid(blocks, selector_.select(blocks, options), 20);
  options.prior = prior.data();
  expect_valid(blocks, selector_.select(blocks, options), 20);
}

TEST_P(Degenerate, priors_that_are_not_symmetric_positive_definite) {
  Random random;
  const BlockStore blocks = random_blocks(random, 20);
  const auto status_with = [&](const Matrix6& information) {
    const EigenPrior prior(information);
    Options options = with_budget(5);
    options.prior = prior.data();
    const Selection selection = selector_.select(blocks, options);
    if (selection.status != Status::ok) expect_error(selection, Status::invalid_prior);
    return selection.status;
  };
  const Matrix6 good = random_prior(random);
  EXPECT_EQ(status_with(good), Status::ok);

  Matrix6 bad = good;
  bad(1, 4) += 1e-3;
  EXPECT_EQ(status_with(bad), Status::invalid_prior) << "not symmetric";
  EXPECT_EQ(status_with(-good), Status::invalid_prior) << "negative definite";
  EXPECT_EQ(status_with(Matrix6::Zero()), Status::invalid_prior) << "zero";
  bad = good;
  bad(3, 3) = 0;
  EXPECT_EQ(status_with(bad), Status::invalid_prior) << "indefinite";
  const Eigen::Matrix<double, 6, 1> direction = Eigen::Matrix<double, 6, 1>::LinSpaced(1, 6);
  EXPECT_EQ(status_with(direction * direction.transpose()), Status::invalid_prior) << "rank 1";
  const Block five = random_block(random, 5);
  EXPECT_EQ(status_with(gram(five)), Status::invalid_prior) << "rank 5";
  EXPECT_EQ(status_with(1e-30 * Matrix6::Identity()), Status::invalid_prior) << "too small to divide by";
  for (const double value : {nan, infinity, -infinity}) {
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        bad = good;
        bad(i, j) = value;
        EXPECT_EQ(status_with(bad), Status::invalid_prior) << i << ' ' << j << ' ' << value;
      }
    }
  }
}

// The limits that docs/numerics.md states, from both sides.
TEST_P(Degenerate, priors_on_both_sides_of_each_limit) {
  const BlockStore blocks;
  const auto status_with = [&](const Matrix6& information) {
    const EigenPrior prior(information);
    Options options = with_budget(0);
    options.prior = prior.data();
    return selector_.select(blocks, options).status;
  };
  for (const double size : {1e-6, 1.0, 1e6}) {
    Matrix6 information = size * Matrix6::Identity();
    information(4, 2) = 0.5e-8 * size;
    EXPECT_EQ(status_with(information), Status::ok) << "asymmetry";
    information(4, 2) = 2e-8 * size;
    EXPECT_EQ(status_with(information), Status::invalid_prior) << "asymmetry";

    information = size * Matrix6::Identity();
    information(3, 1) = information(1, 3) = size * (1 - 1e-13);  // pivot 2e-13
    EXPECT_EQ(status_with(information), Status::ok) << "pivot";
    information(3, 1) = information(1, 3) = size * (1 - 1e-15);  // pivot 2e-15
    EXPECT_EQ(status_with(information), Status::invalid_prior) << "pivot";
  }
  EXPECT_EQ(status_with(1.01e-20 * Matrix6::Identity()), Status::ok);
  EXPECT_EQ(status_with(0.99e-20 * Matrix6::Identity()), Status::invalid_prior);
}

TEST_P(Degenerate, priors_at_the_edge_of_what_is_accepted) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = random_blocks(random, 20);
  Matrix6 graded = Matrix6::Zero();
  for (int i = 0; i < 6; ++i) graded(i, i) = std::pow(10.0, 4 * i - 10);
  for (const Matrix6& information :
       {Matrix6(1e-20 * Matrix6::Identity()), Matrix6(1e300 * Matrix6::Identity()), graded}) {
    const EigenPrior prior(information);
    Options options = with_budget(10);
    options.prior = prior.data();
    expect_valid(blocks, selector_.select(blocks, options), 10);
  }
  Matrix6 rounded = random_prior(random);  // asymmetric by rounding only
  rounded(0, 5) *= 1 + 1e-15;
  const EigenPrior prior(rounded);
  Options options = with_budget(10);
  options.prior = prior.data();
  expect_valid(blocks, selector_.select(blocks, options), 10);
}

TEST_P(Degenerate, more_candidates_than_capacity) {
  Random random;
  const BlockStore blocks = random_blocks(random, 65);
  expect_error(selector_.select(blocks, with_budget(10)), Status::capacity_exceeded);
  Selector none(0);
  expect_error(none.select(blocks, with_budget(0)), Status::capacity_exceeded);
}

TEST_P(Degenerate, capacity_beyond_what_an_index_can_count) {
  EXPECT_THROW(Selector{std::size_t{1} << 32U}, std::bad_alloc);
  EXPECT_THROW(Selector{std::numeric_limits<std::size_t>::max()}, std::bad_alloc);
}

TEST_P(Degenerate, budget_above_capacity) {
  Random random;
  const BlockStore blocks = random_blocks(random, 10);
  expect_error(selector_.select(blocks, with_budget(65)), Status::invalid_budget);
  expect_error(selector_.select(blocks, with_budget(static_cast<std::size_t>(-1))), Status::invalid_budget);
}

TEST_P(Degenerate, epsilon_at_and_beyond_its_ends) {
  Random random;
  const BlockStore blocks = random_blocks(random, 40);
  Options options = with_budget(10);
  for (const double epsilon : {0.0, 1.0, -0.1, 1.1, nan, infinity, -infinity}) {
    options.epsilon = epsilon;
    const Selection selection = selector_.select(blocks, options);
    if (GetParam() == Strategy::stochastic_greedy) {
      expect_error(selection, Status::invalid_epsilon);
    } else {
      expect_valid(blocks, selection, 10);
    }
  }
  for (const double epsilon : {std::numeric_limits<double>::denorm_min(), 1e-300, 0.5, std::nextafter(1.0, 0.0)}) {
    options.epsilon = epsilon;
    expect_valid(blocks, selector_.select(blocks, options), 10);
  }
}

TEST_P(Degenerate, unknown_strategy_and_time_limit) {
  Random random;
  const BlockStore blocks = random_blocks(random, 20);
  Options options = with_budget(5);
  for (const double limit : {-1.0, nan, -infinity}) {
    options.time_limit = limit;
    expect_error(selector_.select(blocks, options), Status::invalid_time_limit);
  }
  options.time_limit = infinity;
  expect_valid(blocks, selector_.select(blocks, options), 5);
  options.strategy = static_cast<Strategy>(1234);
  expect_error(selector_.select(blocks, options), Status::invalid_strategy);
}

// Of what selects one after the other a prefix of the full answer, of the rest the best so far.
TEST_P(Degenerate, deadline_gives_what_was_found_by_then) {
  const bool is_prefix = GetParam() == Strategy::greedy || GetParam() == Strategy::lazy_greedy ||
                         GetParam() == Strategy::stochastic_greedy;
  Random random;
  SCOPED_TRACE(random.name());
  const std::size_t n = 20000;
  const BlockStore blocks = random_blocks(random, n);
  Selector selector(n);
  Options options = with_budget(1000);
  options.epsilon = 0.001;
  const auto full = indices_of(selector.select(blocks, options));
  ASSERT_EQ(full.size(), 1000U);
  bool was_cut = false;
  for (const double limit : {1e-9, 1e-4, 3e-4, 1e-3, 3e-3}) {
    options.time_limit = limit;
    const Selection selection = selector.select(blocks, options);
    expect_valid(blocks, selection, std::min(selection.size, full.size()));
    if (is_prefix) {
      EXPECT_TRUE(std::equal(selection.begin(), selection.end(), full.begin()));
      EXPECT_EQ(selection.status, selection.size < full.size() ? Status::deadline_reached : Status::ok);
    }
    EXPECT_TRUE(selection.status == Status::deadline_reached || indices_of(selection) == full);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8);
    was_cut = was_cut || selection.status == Status::deadline_reached;
  }
  EXPECT_TRUE(was_cut) << "1 ns is not enough for anything";
}

TEST_P(Degenerate, a_moved_selector_keeps_working_and_the_empty_one_says_so) {
  Random random;
  const BlockStore blocks = random_blocks(random, 20);
  Selector first(20);
  const auto before = indices_of(first.select(blocks, with_budget(5)));
  Selector second(std::move(first));
  EXPECT_EQ(indices_of(second.select(blocks, with_budget(5))), before);
  EXPECT_EQ(second.capacity(), 20U);
  first = Selector(1);
  expect_error(first.select(blocks, with_budget(1)), Status::capacity_exceeded);
  EXPECT_EQ(first.capacity(), 1U);
  Selector third = std::move(first);
  // NOLINTNEXTLINE(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  expect_error(first.select(BlockStore(), with_budget(0)), Status::capacity_exceeded);
  // NOLINTNEXTLINE(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  expect_error(first.select(blocks, with_budget(1)), Status::capacity_exceeded);
}

INSTANTIATE_TEST_SUITE_P(, Degenerate, ::testing::ValuesIn(strategies),
                         [](const auto& parameter) { return std::string(to_string(parameter.param)); });
}  // namespace
}  // namespace maxlogdet::test
