// SPDX-License-Identifier: MIT
// A selection that stops at a target is the shortest prefix of the one without that meets it.
#include "sim/hash.hpp"
#include "tests/core/targets.hpp"
#include "tests/support/flushed_denormals.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/pool_executor.hpp"

#include <cmath>
#include <iterator>
#include <string>

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
  Random random;
  SCOPED_TRACE(random.name());
  Tally tally;
  for_every_family(200, [&](const BlockStore& blocks) {
    Problem problem;
    problem.blocks = blocks;
    problem.plain.budget = static_cast<std::size_t>(random.integer(20, 100));
    problem.plain.stochastic.seed = random.seed();
    expect_targets_hold(random, problem, tie, tally);
  });
  expect_conclusive(tally);
}

TEST(Target, stops_at_the_shortest_prefix_on_a_frame_of_2000) {
  Random random;
  SCOPED_TRACE(random.name());
  Tally tally;
  Problem problem;
  problem.blocks = blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[3]);
  problem.plain.budget = 300;
  expect_targets_hold(random, problem, tie, tally, 20);
  expect_conclusive(tally);
}

TEST(RealFrames, targets_stop_at_the_shortest_prefix_that_meets_them) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  Random random;
  SCOPED_TRACE(random.name());
  Tally tally;
  for_real_frames(1, [&](const BlockStore& blocks) {
    Problem problem;
    problem.blocks = blocks;
    problem.plain.budget = 100;
    expect_targets_hold(random, problem, tie, tally, 2);
  });
  expect_conclusive(tally);
}

TEST(Target, keeps_to_priors_and_constraints) {
  Tally tally;
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Problem problem = constrained_problem(random);
    problem.set_prior(random.chance(0.5) ? random_prior(random) : default_information());
    problem.plain.stochastic.seed = variation;
    ASSERT_NO_FATAL_FAILURE(expect_targets_hold(random, problem, 1e-9L, tally, 2));
  }
  expect_conclusive(tally);
}

TEST(Target, gives_the_same_on_every_instruction_set_and_number_of_threads) {
  PoolExecutor pool(3);
  int stopped = 0;
  for (std::uint64_t variation = 0; variation < trials(150); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const std::size_t n = variation % 10 == 0 ? 12000 : 300;
    const BlockStore blocks = variation % 3 == 0   ? ill_conditioned_blocks(random, n)
                              : variation % 3 == 1 ? awkward_blocks(random, n)
                                                   : blocks_of(make_scene(sim::Scene::clustered, n, variation),
                                                               block_kinds[variation % std::size(block_kinds)]);
    Options options;
    options.budget = 60;
    options.strategy = greedy_strategies[variation % 3];
    options.target.efficiency = random.uniform(0.01, 0.6);
    if (random.chance(0.5)) options.target.translation_sigma = std::pow(10.0, random.uniform(-4, 2));
    if (random.chance(0.5)) options.target.rotation_sigma = std::pow(10.0, random.uniform(-4, 2));
    Selector alone(n);
    const Selection expected = alone.select(blocks, options);
    ASSERT_TRUE(expected.has_answer());
    stopped += expected.status == Status::target_reached ? 1 : 0;
    for (const std::string& isa : sim::supported_isas()) {
      SCOPED_TRACE(isa);
      const ForcedIsa forced(isa.c_str());
      Selector selector(n, &pool);
      for (const int threads : {1, 3}) {
        options.threads = threads;
        expect_same_targets(selector.select(blocks, options), expected);
      }
    }
    const FlushedDenormals flushed;
    expect_same_targets(alone.select(blocks, options), expected);
  }
  EXPECT_GT(stopped, 0);
}

// One number for the sizes of many selections, recorded once: no compiler, instruction set or C library may change it.
TEST(Target, stops_at_the_recorded_places) {
  sim::Hash hash;
  for_every_recorded(500, [&](const BlockStore& blocks) {
    Selector selector(500);
    for (const Strategy strategy : greedy_strategies) {
      for (const double share : {0.05, 0.1, 0.2, 0.4, 0.6}) {
        Options options = with_budget(200, strategy);
        options.target.efficiency = share;
        hash.add(selector.select(blocks, options).size);
        options.target.efficiency = 0;
        options.target.translation_sigma = 0.01 / share;
        options.target.rotation_sigma = 0.001 / share;
        hash.add(selector.select(blocks, options).size);
      }
    }
  });
  EXPECT_EQ(hash.value(), 8720424672158799051U);
}

}  // namespace
}  // namespace maxlogdet::test
