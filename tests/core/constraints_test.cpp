// SPDX-License-Identifier: MIT
// Required and excluded candidates, and groups with a maximum each.
#include "tests/core/optimum.hpp"
#include "tests/core/targets.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace maxlogdet::test {
namespace {

// Blocks of 1 to 3 rows, some of them invalid, and any constraints.
Problem random_problem(Random& random, std::size_t max_size) {
  const BlockStore made = random_store(random, 1 + random.index(max_size));
  Problem problem = problem_of(scaled(random, made, 1, 0.03), 0);
  constrain(random, problem, random.chance(0.7));
  return problem;
}

// Greedy over the partition matroid, from scratch.
std::vector<std::uint32_t> oracle_of(const Problem& problem) {
  GreedyOracle<double> oracle(problem.blocks);
  std::vector<std::uint32_t> answer;
  std::map<std::uint32_t, std::size_t> taken;
  const auto take = [&](std::size_t i) {
    oracle.take(i);
    answer.push_back(static_cast<std::uint32_t>(i));
    ++taken[problem.group_of(i)];
  };
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
    if (problem.is_required(i)) take(i);
    if (problem.is_excluded(i)) oracle.exclude(i);
  }
  while (answer.size() < problem.plain.budget) {
    for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
      if (taken[problem.group_of(i)] >= problem.room_of(problem.group_of(i))) oracle.exclude(i);
    }
    const std::size_t best = oracle.best();
    if (best == oracle.size()) break;
    take(best);
  }
  return answer;
}

TEST(Constraints, greedy_equals_the_oracle) {
  for_each_trial(400, [](Random& random) {
    const Problem problem = random_problem(random, 150);
    const std::vector<std::uint32_t> expected = oracle_of(problem);
    Selector selector(problem.capacity());
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      EXPECT_EQ(indices_of(selector.select(problem.blocks, problem.options(strategy))), expected)
          << to_string(strategy);
    }
  });
}

TEST(Constraints, lazy_greedy_equals_greedy_on_frames) {
  for_every_family(1000, [&](const BlockStore& blocks) {
    Random random(blocks.size());
    Problem problem = problem_of(blocks, 0);
    constrain(random, problem);
    problem.plain.budget = std::max<std::size_t>(problem.plain.budget, 100);
    Selector selector(problem.capacity());
    const auto greedy = indices_of(selector.select(blocks, problem.options(Strategy::greedy)));
    EXPECT_EQ(indices_of(selector.select(blocks, problem.options(Strategy::lazy_greedy))), greedy);
  });
}

// Required candidates come first, in the order of their indices.
TEST(Constraints, every_strategy_keeps_to_them_or_says_that_it_cannot) {
  for_each_trial(200, [](Random& random) {
    Problem problem = random_problem(random, 100);
    problem.plain.stochastic.seed = random.seed();
    problem.plain.certificate.compute = random.chance(0.5);
    problem.plain.exchange.sweeps = random.chance(0.5) ? 2 : 0;
    problem.plain.time_limit = random.chance(0.5) ? 1e-9 : 0;
    std::vector<std::uint32_t> required;
    for (std::uint32_t i = 0; i < problem.blocks.size(); ++i) {
      if (problem.is_required(i)) required.push_back(i);
    }
    Selector selector(problem.capacity());
    for (const Strategy strategy : strategies) {
      SCOPED_TRACE(to_string(strategy));
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      if (!problem.groups.empty() && !supports_groups_and_targets(strategy)) {
        EXPECT_EQ(selection.error, Error::unsupported_groups);
        continue;
      }
      expect_sound(problem, selection);
      EXPECT_TRUE(std::equal(required.begin(), required.end(), selection.begin()));
    }
  });
}

Problem small_problem_of_groups(Random& random) {
  const auto n = static_cast<std::size_t>(random.integer(2, 11));
  Problem problem = problem_of(awkward_blocks(random, n), 1 + random.index(n));
  const int count = random.integer(1, 4);
  for (int g = 0; g < count; ++g) problem.maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 2)));
  for (std::size_t i = 0; i < n; ++i) {
    problem.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
  }
  problem.plain.certificate.compute = true;
  problem.set_prior(Matrix6::Identity());
  return problem;
}

// The guarantee of greedy over a matroid, against every feasible subset. The prior's log det is 0.
TEST(Constraints, greedy_reaches_at_least_half_of_the_optimum) {
  double worst = 1;
  for_each_trial(300, [&](Random& random) {
    const Problem problem = small_problem_of_groups(random);
    const long double optimum = Optimum(problem, true).of(problem.plain.budget);
    Selector selector(problem.capacity());
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      EXPECT_GE(selection.log_det, optimum / 2 - 1e-9L);
      EXPECT_LE(selection.log_det, optimum + 1e-9L);
      EXPECT_GE(selection.upper_bound, optimum - 1e-12L);
      if (optimum > 0) worst = std::min(worst, static_cast<double>(selection.log_det / optimum));
    }
  });
  std::printf("worst greedy / optimum over groups: %.3f (guaranteed 0.5)\n", worst);
}

TEST(Constraints, one_maximum_for_all_groups) {
  Random random;
  Problem problem = problem_of(scaled(random, random_store(random, 60), 1, 0.03), 60);
  for (std::uint32_t i = 0; i < 60; ++i) problem.groups.push_back(i % 6);
  problem.plain.groups.count = 6;
  Selector selector(60);
  for (const std::size_t maximum : {0U, 1U, 4U, 1000U}) {
    problem.plain.groups.maximum = maximum;
    const Selection selection = selector.select(problem.blocks, problem.options());
    expect_sound(problem, selection);
    EXPECT_EQ(selection.size, maximum == 1000 ? problem.blocks.stored() : 6 * maximum);
  }
}

// Groups may be numbered as objects or the cells of a fine grid are, beyond the selector's capacity: the answer is that
// of the same groups numbered from 0 on.
TEST(Constraints, groups_may_have_any_numbers) {
  for_each_trial(300, [](Random& random) {
    Problem problem = random_problem(random, 60);
    if (problem.groups.empty()) return;
    problem.plain.exchange.sweeps = 2;
    problem.plain.certificate.compute = true;
    if (random.chance(0.5)) {
      problem.plain.groups.count = problem.maxima.size();
      problem.plain.groups.maximum = 3;
      problem.maxima.clear();
      problem.required.clear();  // more of them may be in a group
    }
    Problem renamed = problem;
    if (problem.maxima.empty()) {
      for (std::uint32_t& group : renamed.groups) group = std::numeric_limits<std::uint32_t>::max() - 1000 * group;
      renamed.plain.groups.count = std::size_t{1} << 32U;
    } else {
      constexpr std::uint32_t step = 7919;
      renamed.maxima.assign(problem.maxima.size() * step, 77);
      for (std::size_t g = 0; g < problem.maxima.size(); ++g) renamed.maxima[(g + 1) * step - 1] = problem.maxima[g];
      for (std::uint32_t& group : renamed.groups) group = (group + 1) * step - 1;
    }
    for (const Strategy strategy : greedy_strategies) {
      const Answer expected = answer_to(problem.blocks, problem.options(strategy));
      EXPECT_EQ(answer_to(problem.blocks, renamed.options(strategy)), expected);
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
