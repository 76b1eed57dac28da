// SPDX-License-Identifier: MIT
// Requests at and beyond the edges: a valid answer or a named status, from every strategy.
#include "tests/core/degenerate.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>
#include <utility>

namespace maxlogdet::test {
namespace {

// How the strategy ends with this prior.
Error error_with(Selector& selector, const BlockStore& blocks, Options options, const Matrix6& information) {
  const EigenPrior prior(information);
  options.prior = prior.data();
  return selector.select(blocks, options).error;
}

TEST_P(Degenerate, priors_that_are_not_symmetric_positive_definite) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  const Matrix6 good = random_prior(random);
  Matrix6 asymmetric = good;
  asymmetric(1, 4) += 1e-3;
  Matrix6 indefinite = good;
  indefinite(3, 3) = 0;
  const Eigen::Matrix<double, 6, 1> direction = Eigen::Matrix<double, 6, 1>::LinSpaced(1, 6);
  const struct {
    const char* name;
    Matrix6 prior;
  } cases[] = {{"not symmetric", asymmetric},
               {"negative definite", -good},
               {"zero", Matrix6::Zero()},
               {"indefinite", indefinite},
               {"rank 1", direction * direction.transpose()},
               {"rank 5", gram(random_block(random, 5))},
               {"too small to divide by", 1e-30 * Matrix6::Identity()}};
  EXPECT_EQ(error_with(selector_, blocks, asking_for(5), good), Error::none);
  for (const auto& of : cases) {
    EXPECT_EQ(error_with(selector_, blocks, asking_for(5), of.prior), Error::invalid_prior) << of.name;
  }
  for (const double value : {nan, infinity, -infinity}) {
    for (int entry = 0; entry < 36; ++entry) {
      Matrix6 bad = good;
      bad(entry) = value;
      EXPECT_EQ(error_with(selector_, blocks, asking_for(5), bad), Error::invalid_prior) << entry << ' ' << value;
    }
  }
  const EigenPrior zero{Matrix6(Matrix6::Zero())};
  Options options = asking_for(5);
  options.prior = zero.data();
  expect_error(selector_.select(blocks, options), Error::invalid_prior);
}

// The limits that docs/numerics.md states, from both sides.
TEST_P(Degenerate, priors_on_both_sides_of_each_limit) {
  const auto expect = [&](const Matrix6& prior, Error error) {
    EXPECT_EQ(error_with(selector_, BlockStore(), asking_for(0), prior), error) << prior;
  };
  for (const double size : {1e-6, 1.0, 1e6}) {
    Matrix6 prior = size * Matrix6::Identity();
    prior(4, 2) = 0.5e-8 * size;  // asymmetry
    expect(prior, Error::none);
    prior(4, 2) = 2e-8 * size;
    expect(prior, Error::invalid_prior);
    prior = size * Matrix6::Identity();
    prior(3, 1) = prior(1, 3) = size * (1 - 1e-13);  // pivot 2e-13
    expect(prior, Error::none);
    prior(3, 1) = prior(1, 3) = size * (1 - 1e-15);  // pivot 2e-15
    expect(prior, Error::invalid_prior);
  }
  expect(1.01e-20 * Matrix6::Identity(), Error::none);
  expect(0.99e-20 * Matrix6::Identity(), Error::invalid_prior);
}

TEST_P(Degenerate, priors_at_the_edge_of_what_is_accepted) {
  TracedRandom random;
  const BlockStore blocks = random_store(random, 20);
  Matrix6 graded = Matrix6::Zero();
  for (int i = 0; i < 6; ++i) graded(i, i) = std::pow(10.0, 4 * i - 10);
  Matrix6 rounded = random_prior(random);  // asymmetric by rounding only
  rounded(0, 5) *= 1 + 1e-15;
  for (const Matrix6& information :
       {Matrix6(1e-20 * Matrix6::Identity()), Matrix6(1e300 * Matrix6::Identity()), graded, rounded}) {
    const EigenPrior prior(information);
    Options options = asking_for(10);
    options.prior = prior.data();
    expect_valid(blocks, selector_.select(blocks, options), 10, infinity, information);
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

// As many candidates as without a limit. Of strategies that select one candidate after the other,
// what was searched is a prefix of the full answer; backward greedy has searched nothing. On one thread and on two,
// and with exchanges, which keep what they have.
TEST_P(Degenerate, deadline_fills_the_budget) {
  PoolExecutor pool(1);
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::clustered, 10000, 5), block_kinds[3]);
  Selector selector(10000, &pool);
  for (const int threads : {1, 2}) {
    for (const std::size_t sweeps : {0U, 100U}) {
      SCOPED_TRACE(std::to_string(threads) + " threads, sweeps " + std::to_string(sweeps));
      Options options = asking_for(150);
      options.threads = threads;
      const Answer before(selector.select(blocks, options));
      options.exchange.sweeps = sweeps;
      const Selection whole = selector.select(blocks, options);
      const double log_det = whole.log_det;
      const Answer full(whole);
      ASSERT_EQ(full.reason, "ok");
      const bool is_prefix = full.strategy != Strategy::relaxed && full.strategy != Strategy::backward_greedy;
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
        if (is_prefix && sweeps == 0) {
          EXPECT_LT(selection.searched, 150U);
          EXPECT_TRUE(std::equal(selection.begin(), selection.begin() + selection.searched, full.indices.begin()));
        }
        if (full.strategy == Strategy::backward_greedy && sweeps == 0) {
          EXPECT_EQ(selection.searched, 0U);
        }
        if (selection.searched == 150 && sweeps > 0 && full.strategy != Strategy::relaxed) {  // exchanges were cut
          EXPECT_GE(log_det_of(blocks, indices_of(selection)), log_det_of(blocks, before.indices));
        }
      }
      EXPECT_TRUE(was_cut) << "1 ns is not enough for anything";
    }
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

}  // namespace
}  // namespace maxlogdet::test
