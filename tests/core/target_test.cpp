// SPDX-License-Identifier: MIT
// A selection that stops at a target is the shortest prefix of the one without that meets it.
#include "tests/core/targets.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

// Nothing is reported that no target is about.
void expect_reported(double reported, double target, long double expected, long double tolerance) {
  if (target > 0) {
    EXPECT_NEAR(reported, static_cast<double>(expected), static_cast<double>(expected * tolerance));
  } else {
    EXPECT_TRUE(std::isnan(reported)) << reported;
  }
}

// Draws targets and checks them with each strategy.
void expect_targets_hold(Random& random, Problem& problem, long double tolerance, Tally& tally, int repetitions = 4) {
  Selector selector(problem.capacity());
  const long double all = log_det_of_all(problem);
  for (const Strategy strategy : greedy_strategies) {
    problem.plain.strategy = strategy;
    const auto full = indices_of(selector.select(problem.blocks, full_of(problem)));
    const std::vector<Reached> reached = reached_by_prefixes(problem, full, all);
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      draw_targets(random, reached, problem.plain);
      const Selection selection = selector.select(problem.blocks, problem.options());
      ASSERT_NO_FATAL_FAILURE(expect_shortest(problem, full, reached, tolerance, selection, tally));
      const Reached& end = reached[selection.size];
      expect_reported(selection.efficiency, problem.plain.target.efficiency, end.efficiency, 1e-9L);
      expect_reported(selection.translation_sigma, problem.plain.target.translation_sigma, end.translation_sigma,
                      1e-9L);
      expect_reported(selection.rotation_sigma, problem.plain.target.rotation_sigma, end.rotation_sigma, 1e-9L);
    }
  }
}

constexpr long double tie = 1e-11L;

TEST(Target, stops_at_the_shortest_prefix_that_meets_it) {
  TracedRandom random;
  Tally tally;
  for_every_family(200, [&](const BlockStore& blocks) {
    Problem problem = problem_of(blocks, static_cast<std::size_t>(random.integer(20, 100)));
    problem.plain.stochastic.seed = random.seed();
    expect_targets_hold(random, problem, tie, tally);
  });
  const BlockStore many = blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[3]);
  Problem problem = problem_of(many, 300);
  expect_targets_hold(random, problem, tie, tally, 20);
  expect_conclusive(tally);
}

TEST(RealFrames, targets_stop_at_the_shortest_prefix_that_meets_them) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  TracedRandom random;
  Tally tally;
  for_real_frames(1, [&](const BlockStore& blocks) {
    Problem problem = problem_of(blocks, 100);
    expect_targets_hold(random, problem, tie, tally, 2);
  });
  expect_conclusive(tally);
}

TEST(Target, keeps_to_priors_and_constraints) {
  Tally tally;
  for_each_trial(400, [&](Random& random) {
    Problem problem = constrained_problem(random);
    if (random.chance(0.5)) problem.set_prior(random_prior(random));
    problem.plain.stochastic.seed = random.seed();
    expect_targets_hold(random, problem, 1e-9L, tally, 2);
  });
  expect_conclusive(tally);
}

}  // namespace
}  // namespace maxlogdet::test
