// SPDX-License-Identifier: MIT
// A selection that stops at a target is the shortest prefix of the one without that meets it: against an oracle in long
// double, and where it can be computed by hand; and invalid targets.
#include "tests/core/factors.hpp"
#include "tests/core/targets.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

TEST(Target, stops_at_the_shortest_prefix_that_meets_it) {
  TracedRandom random;
  Tally tally;
  for (const std::size_t n : {200U, 2000U}) {
    for_every_family(n, [&](const BlockStore& blocks) {
      Problem problem = problem_of(blocks, static_cast<std::size_t>(random.integer(20, 100)));
      problem.plain.stochastic.seed = random.seed();
      for (const Strategy strategy : strategies) {
        problem.plain.strategy = strategy;
        expect_drawn_targets_hold(random, problem, 1e-11L, tally, 4);
      }
    });
  }
  expect_conclusive(tally);
}

// Duplicates, multiples, zeros, near copies and invalid candidates, with required candidates and groups; or none at
// all.
Problem constrained_problem(Random& random) {
  const std::size_t n = random.chance(0.1) ? 0 : static_cast<std::size_t>(random.integer(1, 120));
  Problem problem = problem_of(scaled(random, awkward_blocks(random, n), 1, random.chance(0.3) ? 0.1 : 0), 0);
  constrain(random, problem, random.chance(0.4));
  problem.set_prior(random.chance(0.5) ? random_prior(random) : weak_information());
  problem.plain.stochastic.seed = random.seed();
  return problem;
}

TEST(Target, keeps_to_priors_and_constraints) {
  Tally tally;
  for_each_trial(400, [&](Random& random) {
    Problem problem = constrained_problem(random);
    for (const Strategy strategy : strategies) {
      problem.plain.strategy = strategy;
      expect_drawn_targets_hold(random, problem, 1e-9L, tally, 2);
    }
  });
  expect_conclusive(tally);
}

// A hundredth of what is proved of the factors of the answer and of all candidates, a worst case which no draw here
// comes near.
long double tolerance_of(const Problem& problem) {
  InformationFactor all = factor_of(problem.information());
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) add(all, stored_block(problem.blocks, i));
  return static_cast<long double>(2 * all.relative_error() + large_error) / 100;
}

TEST(Target, is_right_well_within_the_proven_error_of_the_factor_on_ill_conditioned_information) {
  Tally tally;
  for_each_trial(300, [&](Random& random) {
    const Problem problem = problem_of(ill_conditioned_blocks(random, random.chance(0.1) ? 2000 : 60), 40);
    expect_drawn_targets_hold(random, problem, tolerance_of(problem), tally, 5);
  });
  expect_conclusive(tally, 0.1);
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
  Selector selector(501);
  const Prefixes prefixes(selector, problem);
  Tally tally;
  for (const double share : {0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99}) {
    problem.plain.target.efficiency = share;
    expect_shortest(selector, problem, prefixes, 1e-7L, tally);
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

// Information from the smallest to the largest that float64 holds, and blocks of the size of the prior or as large as
// there are: products of their entries would leave the range, and efficiencies begin at 1e-97.
TEST(Target, needs_no_number_beyond_the_range_of_float64) {
  for (const double scale : {1e-20, 1e-10, 1.0, 1e10, 1e100, 1e200, 1e300, 1.7e308}) {
    for (const double entry : {std::min(3e38, std::sqrt(scale)), 3e38}) {
      TracedRandom random;
      SCOPED_TRACE(std::to_string(scale) + ", blocks of " + std::to_string(entry));
      Problem problem = problem_of(rows_along_axes(entry, 60), 60);
      problem.set_prior(scale * Matrix6::Identity());
      Tally tally;
      expect_drawn_targets_hold(random, problem, 1e-9L, tally, 40);
    }
  }
}

// Of rows of 1 along every axis, with a prior of I, a selection of `size` has 1 + (size + 5 - d) / 6 in direction d:
// they are taken in turn. It says what it has reached, where a target is about it.
void expect_by_hand(const Selection& selection, const TargetOptions& target) {
  double product = 1;
  double variances[2] = {};
  for (std::size_t d = 0; d < 6; ++d) {
    const auto information = static_cast<double>(1 + (selection.size + 5 - d) / 6);
    product *= information / 101;
    variances[d / 3] += 1 / information;
  }
  const auto expect = [](double reported, double asked, double expected) {
    EXPECT_TRUE(asked > 0 ? std::abs(reported - expected) < 1e-12 : std::isnan(reported)) << reported;
  };
  expect(selection.efficiency, target.efficiency, std::pow(product, 1.0 / 6));
  expect(selection.translation_sigma, target.translation_sigma, std::sqrt(variances[0]));
  expect(selection.rotation_sigma, target.rotation_sigma, std::sqrt(variances[1]));
}

TEST(Target, agrees_with_computation_by_hand) {
  const double sigma = std::sqrt(3 / 20.5);
  const struct {
    const char* why;
    std::size_t budget;
    double efficiency, translation_sigma, rotation_sigma;
    Status status;
    std::size_t size;
  } cases[] = {
      {"10^5 11 = 1.1e6 is above 10.1^6 = 1.0615e6, 10^6 is not", 600, 0.1, 0, 0, Status::target_reached, 55},
      {"the budget comes first", 54, 0.1, 0, 0, Status::ok, 54},
      {"both come together", 55, 0.1, 0, 0, Status::target_reached, 55},
      {"19 rounds have 3 / 20, the twentieth needs the second of the three: 1 / 20 + 2 / 21 = 0.14524 is below "
       "3 / 20.5 = 0.14634, 2 / 20 + 1 / 21 is not",
       600, 0, sigma, 0, Status::target_reached, 116},
      {"of two the harder one counts", 600, 0, sigma, std::sqrt(3 / 30.0) * 1.000001, Status::target_reached, 174},
      {"what the prior has is 1.732", 600, 0, sigma, 1.7, Status::target_reached, 116},
      {"out of reach", 600, 0, 1e-3, 0, Status::all_selected, 600},
      {"the smallest deviations", 600, 0, 5e-324, 1e-308, Status::all_selected, 600},
      {"the smallest share", 600, 5e-324, 0, 0, Status::target_reached, 0},
      {"also by the last one", 600, 1 - 1e-9, 0, 0, Status::target_reached, 600},
      {"met before the search", 100, 0, 0, 1.8, Status::target_reached, 0},
      {"met without a budget", 0, 0, 0, 1.8, Status::target_reached, 0},
      {"not met without a budget", 0, 0, 0, 1.5, Status::ok, 0},
      {"-0 is no target", 10, -0.0, -0.0, -0.0, Status::ok, 10},
  };
  Problem problem = problem_of(rows_along_axes(1, 600), 0);
  problem.set_prior(Matrix6::Identity());
  Selector selector(600);
  for (const auto& of : cases) {
    SCOPED_TRACE(of.why);
    problem.plain.budget = of.budget;
    problem.plain.target.efficiency = of.efficiency;
    problem.plain.target.translation_sigma = of.translation_sigma;
    problem.plain.target.rotation_sigma = of.rotation_sigma;
    const Selection selection = selector.select(problem.blocks, problem.options());
    EXPECT_EQ(selection.status, of.status);
    EXPECT_EQ(selection.size, of.size);
    expect_by_hand(selection, problem.plain.target);
  }
}

TEST(Target, of_all_is_met_when_all_are_selected_or_rounding_is_all_that_is_missing) {
  Selector selector(100);
  for_every_family(100, [&](const BlockStore& blocks) {
    Options options = with_budget(blocks.size());
    options.target.efficiency = 1;
    const Selection selection = selector.select(blocks, options);
    EXPECT_TRUE(selection.status == Status::target_reached || selection.status == Status::all_selected);
    EXPECT_NEAR(selection.efficiency, 1, 1e-9);
    EXPECT_EQ(selector.select(BlockStore(), options).status, Status::target_reached) << "of no candidates";
  });
}

TEST(Target, that_is_invalid_is_named) {
  const BlockStore blocks = rows_along_axes(1, 60);
  Selector selector(60);
  for (double TargetOptions::*const target :
       {&TargetOptions::efficiency, &TargetOptions::translation_sigma, &TargetOptions::rotation_sigma}) {
    for (const double bad : {-1e-300, -1.0, nan, infinity, -infinity, std::nextafter(1.0, 2.0)}) {
      const bool is_deviation = bad > 1 && bad < infinity && target != &TargetOptions::efficiency;
      Options options = with_budget(10);
      options.target.*target = bad;
      const Selection selection = selector.select(blocks, options);
      EXPECT_EQ(selection.error, is_deviation ? Error::none : Error::invalid_target) << bad;
      if (is_deviation) continue;
      EXPECT_EQ(selection.size, 0U);
      for (const double number :
           {selection.log_det, selection.efficiency, selection.translation_sigma, selection.rotation_sigma}) {
        EXPECT_TRUE(std::isnan(number)) << number;
      }
    }
  }
}

TEST(Target, leaves_the_upper_bound_that_of_the_budget) {
  TracedRandom random;
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 300, random.seed()), block_kinds[2]);
  Selector selector(300);
  Options options = with_budget(60);
  options.certificate = true;
  const double log_det = selector.select(blocks, options).log_det;
  options.target.efficiency = 0.2;
  const Selection selection = selector.select(blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_LT(selection.size, 60U);
  EXPECT_GE(selection.upper_bound, log_det);
}

}  // namespace
}  // namespace maxlogdet::test
