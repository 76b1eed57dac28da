// SPDX-License-Identifier: MIT
// Requests at and beyond the edges: a valid answer or a named status, from every strategy.
#include "tests/core/degenerate.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>
#include <utility>

namespace maxlogdet::test {
namespace {

TEST_P(Degenerate, priors_that_are_not_symmetric_positive_definite) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  const auto error_with = [&](const Matrix6& information) {
    const EigenPrior prior(information);
    Options options = asking_for(5);
    options.prior = prior.data();
    const Selection selection = selector_.select(blocks, options);
    if (selection.status != Status::ok) expect_error(selection, Error::invalid_prior);
    return selection.error;
  };
  const Matrix6 good = random_prior(random);
  EXPECT_EQ(error_with(good), Error::none);

  Matrix6 bad = good;
  bad(1, 4) += 1e-3;
  EXPECT_EQ(error_with(bad), Error::invalid_prior) << "not symmetric";
  EXPECT_EQ(error_with(-good), Error::invalid_prior) << "negative definite";
  EXPECT_EQ(error_with(Matrix6::Zero()), Error::invalid_prior) << "zero";
  bad = good;
  bad(3, 3) = 0;
  EXPECT_EQ(error_with(bad), Error::invalid_prior) << "indefinite";
  const Eigen::Matrix<double, 6, 1> direction = Eigen::Matrix<double, 6, 1>::LinSpaced(1, 6);
  EXPECT_EQ(error_with(direction * direction.transpose()), Error::invalid_prior) << "rank 1";
  const Block five = random_block(random, 5);
  EXPECT_EQ(error_with(gram(five)), Error::invalid_prior) << "rank 5";
  EXPECT_EQ(error_with(1e-30 * Matrix6::Identity()), Error::invalid_prior) << "too small to divide by";
  for (const double value : {nan, infinity, -infinity}) {
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        bad = good;
        bad(i, j) = value;
        EXPECT_EQ(error_with(bad), Error::invalid_prior) << i << ' ' << j << ' ' << value;
      }
    }
  }
}

// The limits that docs/numerics.md states, from both sides.
TEST_P(Degenerate, priors_on_both_sides_of_each_limit) {
  const BlockStore blocks;
  const auto error_with = [&](const Matrix6& information) {
    const EigenPrior prior(information);
    Options options = asking_for(0);
    options.prior = prior.data();
    return selector_.select(blocks, options).error;
  };
  for (const double size : {1e-6, 1.0, 1e6}) {
    Matrix6 information = size * Matrix6::Identity();
    information(4, 2) = 0.5e-8 * size;
    EXPECT_EQ(error_with(information), Error::none) << "asymmetry";
    information(4, 2) = 2e-8 * size;
    EXPECT_EQ(error_with(information), Error::invalid_prior) << "asymmetry";

    information = size * Matrix6::Identity();
    information(3, 1) = information(1, 3) = size * (1 - 1e-13);  // pivot 2e-13
    EXPECT_EQ(error_with(information), Error::none) << "pivot";
    information(3, 1) = information(1, 3) = size * (1 - 1e-15);  // pivot 2e-15
    EXPECT_EQ(error_with(information), Error::invalid_prior) << "pivot";
  }
  EXPECT_EQ(error_with(1.01e-20 * Matrix6::Identity()), Error::none);
  EXPECT_EQ(error_with(0.99e-20 * Matrix6::Identity()), Error::invalid_prior);
}

TEST_P(Degenerate, priors_at_the_edge_of_what_is_accepted) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = random_store(random, 20);
  Matrix6 graded = Matrix6::Zero();
  for (int i = 0; i < 6; ++i) graded(i, i) = std::pow(10.0, 4 * i - 10);
  for (const Matrix6& information :
       {Matrix6(1e-20 * Matrix6::Identity()), Matrix6(1e300 * Matrix6::Identity()), graded}) {
    const EigenPrior prior(information);
    Options options = asking_for(10);
    options.prior = prior.data();
    expect_valid(blocks, selector_.select(blocks, options), 10);
  }
  Matrix6 rounded = random_prior(random);  // asymmetric by rounding only
  rounded(0, 5) *= 1 + 1e-15;
  const EigenPrior prior(rounded);
  Options options = asking_for(10);
  options.prior = prior.data();
  expect_valid(blocks, selector_.select(blocks, options), 10);
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

TEST_P(Degenerate, a_budget_above_the_capacity_selects_all) {
  Random random;
  const BlockStore blocks = random_store(random, 10);
  for (const std::size_t budget : {std::size_t{11}, std::size_t{65}, std::numeric_limits<std::size_t>::max()}) {
    const Selection selection = selector_.select(blocks, asking_for(budget));
    EXPECT_EQ(selection.status, Status::all_selected);
    EXPECT_EQ(selection.size, 10U);
  }
  EXPECT_EQ(Options(-1).budget, 0U);
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

// Of strategies that select one candidate after the other, what was searched is a prefix of the full answer.
TEST_P(Degenerate, deadline_fills_the_budget) {
  const bool is_prefix = GetParam() == Strategy::greedy || GetParam() == Strategy::lazy_greedy ||
                         GetParam() == Strategy::stochastic_greedy;
  Random random;
  SCOPED_TRACE(random.name());
  const std::size_t n = 20000;
  const BlockStore blocks = random_store(random, n);
  Selector selector(n);
  Options options = asking_for(1000);
  options.stochastic.epsilon = 0.001;
  const auto full = indices_of(selector.select(blocks, options));
  ASSERT_EQ(full.size(), 1000U);
  bool was_cut = false;
  for (const double limit : {1e-9, 1e-4, 3e-4, 1e-3, 3e-3}) {
    options.time_limit = limit;
    const Selection selection = selector.select(blocks, options);
    expect_valid(blocks, selection, full.size());
    if (is_prefix) {
      EXPECT_TRUE(std::equal(selection.begin(), selection.begin() + selection.searched, full.begin()));
      EXPECT_EQ(selection.status, selection.searched < full.size() ? Status::deadline_reached : Status::ok);
    }
    EXPECT_TRUE(selection.status == Status::deadline_reached || indices_of(selection) == full);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8);
    was_cut = was_cut || selection.status == Status::deadline_reached;
  }
  EXPECT_TRUE(was_cut) << "1 ns is not enough for anything";
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

}  // namespace
}  // namespace maxlogdet::test
