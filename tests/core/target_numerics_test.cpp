// SPDX-License-Identifier: MIT
// Targets where float64 has few digits: information of any condition number, and numbers from the smallest to the
// largest.
#include "kernel/blocks/candidates.hpp"
#include "tests/core/factors.hpp"
#include "tests/core/targets.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace maxlogdet::test {
namespace {

// A hundredth of the error bounds of the factors of an answer and of all candidates: these are bounds of the worst
// case, which no draw here comes near.
long double tolerance_of(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, int& row_by_row) {
  const Matrix6 information = default_information(blocks);
  const EigenPrior prior(information);
  InformationFactor selected = factor_of(information);
  for (const std::uint32_t i : indices) add(selected, stored_block(blocks, i));
  // The sum of all at once, where its bound is small.
  const std::vector<unsigned char> counted(blocks.stored(), 1);
  double sum[state_dimension * state_dimension];
  const Candidates candidates = all_of(blocks, *simd::active());
  candidates.exact().sum_information(candidates.planes, counted.data(), blocks.stored(), sum);
  const double roundings = simd::sum_roundings(blocks.stored(), blocks.rows());
  InformationFactor all;
  double error =
      all.reset(prior.data(), sum, roundings) ? all.determinant_error(prior.data(), sum, roundings) : infinity;
  if (error >= large_error) {
    all = factor_of(information);
    for (std::size_t i = 0; i < blocks.size(); ++i) add(all, stored_block(blocks, i));
    error = all.relative_error();
    ++row_by_row;
  }
  return static_cast<long double>(selected.relative_error() + error) / 100 + 1e-15L;
}

TEST(Target, is_right_well_within_the_proven_error_of_the_factor_on_ill_conditioned_information) {
  Tally tally;
  int without_digits = 0;
  int row_by_row = 0;
  for_each_trial(300, [&](Random& random) {
    Problem problem = problem_of(ill_conditioned_blocks(random, random.chance(0.1) ? 2000 : 60), 40);
    const long double all = log_det_of_all(problem);
    Selector selector(2000);
    const auto full = indices_of(selector.select(problem.blocks, full_of(problem)));
    const std::vector<Reached> reached = reached_by_prefixes(problem, full, all);
    const long double tolerance = tolerance_of(problem.blocks, full, row_by_row);
    without_digits += tolerance > 0.1L ? 1 : 0;
    for (int repetition = 0; repetition < 5; ++repetition) {
      draw_targets(random, reached, problem.plain);
      const Selection selection = selector.select(problem.blocks, problem.options());
      expect_shortest(problem, full, reached, tolerance, selection, tally);
    }
  });
  std::printf(
      "%d problems without digits, %d summed row by row; of %d selections %d were cut, %d were too near "
      "to tell\n",
      without_digits, row_by_row, tally.selections, tally.cut, tally.ties);
  EXPECT_GT(3 * tally.cut, tally.selections);
  EXPECT_LE(10 * tally.ties, tally.selections);
}

// A direction that a single block observes, so weakly that a sum keeps no digits of it: the efficiency is right
// nevertheless.
TEST(Target, needs_no_digits_of_a_sum) {
  TracedRandom random;
  Block weak = Block::Zero(1, 6);
  weak(0, 5) = 1e-2;  // ten times the prior
  const BlockStore blocks = store_of(501, [&](std::size_t i) {
    if (i == 500) return weak;
    Block block = random_block(random, 2, 1e5);  // 1e10 in a sum of 1e12, against 1e-5 of the prior
    block.col(5).setZero();
    return block;
  });
  Problem problem = problem_of(blocks, 501);
  problem.set_prior(weak_information());
  const long double all = log_det_of_all(problem);
  Selector selector(501);
  const auto full = indices_of(selector.select(problem.blocks, full_of(problem)));
  const std::vector<Reached> reached = reached_by_prefixes(problem, full, all);
  Tally tally;
  for (const double share : {0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99}) {
    problem.plain.target.efficiency = share;
    const Selection selection = selector.select(problem.blocks, problem.options());
    expect_shortest(problem, full, reached, 1e-7L, selection, tally);
    EXPECT_NEAR(selection.efficiency, static_cast<double>(reached[selection.size].efficiency), 1e-7);
  }
  EXPECT_EQ(tally.ties, 0);
}

// Rows of one entry each, in turn along every axis.
BlockStore rows_along_axes(double entry, std::size_t n) {
  return store_of(n, [&](std::size_t i) {
    Block block = Block::Zero(1, 6);
    block(0, static_cast<int>(i % 6)) = entry;
    return block;
  });
}

// The prior is `scale` times the identity; where it is strong, blocks are rounding.
bool is_strong(double scale) { return scale > 1e77; }

void expect_deviations(const BlockStore& blocks, Options options, double scale) {
  Selector selector(60);
  const double sigma = std::sqrt(3 / scale);  // before the first one
  for (const double factor : {1e-3, 0.9999, 1.0001, 1e3}) {
    options.target.translation_sigma = options.target.rotation_sigma = factor * sigma;
    const Selection selection = selector.select(blocks, options);
    ASSERT_TRUE(selection.has_answer());
    EXPECT_NEAR(selection.translation_sigma / sigma, selection.size == 0 || is_strong(scale) ? 1 : 0.5, 0.5);
    EXPECT_EQ(selection.size == 0 && selection.status == Status::target_reached, factor > 1) << factor;
  }
  options.target.rotation_sigma = 0;
  for (const double tiny : {5e-324, 1e-308, 1e-200}) {
    options.target.translation_sigma = tiny;
    EXPECT_EQ(selector.select(blocks, options).status, Status::all_selected);
  }
  options.target.translation_sigma = 1e300;
  EXPECT_EQ(selector.select(blocks, options).size, 0U);
}

void expect_efficiencies(const BlockStore& blocks, Options options, double scale) {
  Selector selector(60);
  for (const double share : {1e-300, 1e-100, 1e-3, 0.0899, 0.0919, 0.5, 0.999999}) {
    options.target.efficiency = share;
    const Selection selection = selector.select(blocks, options);
    ASSERT_TRUE(selection.has_answer());
    if (is_strong(scale)) {
      EXPECT_EQ(selection.size, 0U) << share;
      EXPECT_EQ(selection.status, Status::target_reached);
    } else {  // 1 of 11 before the first one
      EXPECT_EQ(selection.size == 0, share < 1.0 / 11) << share << ' ' << selection.size;
      EXPECT_EQ(selection.size == 60, share > 0.99) << share;
    }
  }
}

// Information from the smallest to the largest that float64 holds: products of its entries would leave its range.
TEST(Target, needs_no_number_beyond_the_range_of_float64) {
  for (const double scale : {1e-19, 1e-10, 1.0, 1e10, 1e100, 1e200, 1e300, 1.7e308}) {
    SCOPED_TRACE(scale);
    const EigenPrior prior(Matrix6(scale * Matrix6::Identity()));
    const BlockStore blocks = rows_along_axes(std::min(1e38, std::sqrt(scale)), 60);
    Options options = with_budget(60);
    options.prior = prior.data();
    expect_deviations(blocks, options, scale);
    expect_efficiencies(blocks, options, scale);
  }
}

// Efficiencies from 1e-50 on, where blocks are the largest that there are.
TEST(Target, holds_over_all_that_blocks_and_priors_allow) {
  const EigenPrior prior(Matrix6(1e-20 * Matrix6::Identity()));
  const BlockStore blocks = rows_along_axes(3e38, 6);
  Options options = with_budget(6);
  options.prior = prior.data();
  Selector selector(6);
  // With m of the six the efficiency is (1e-20 / 9e76)^(1 - m / 6).
  for (int m = 0; m < 6; ++m) {
    for (const double off : {0.99, 1.01}) {
      options.target.efficiency = std::pow(1e-20 / 9e76, 1 - m / 6.0) * off;
      const Selection selection = selector.select(blocks, options);
      EXPECT_EQ(selection.status, Status::target_reached);
      EXPECT_EQ(selection.size, static_cast<std::size_t>(off < 1 ? m : m + 1)) << m;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
