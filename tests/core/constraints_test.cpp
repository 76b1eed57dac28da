// SPDX-License-Identifier: MIT
// Required candidates, and groups with a maximum.
#include "tests/core/optimum.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <string>

namespace maxlogdet::test {
namespace {

// Blocks of 1 to 3 rows, some of them invalid, and any constraints. Groups may be numbered as objects or the cells of a
// fine grid are, beyond the selector's capacity.
Problem random_problem(Random& random, std::size_t max_size) {
  const BlockStore made = random_store(random, 1 + random.index(max_size));
  Problem problem = problem_of(scaled(random, made, 1, 0.03), 0);
  constrain(random, problem, random.chance(0.7));
  if (problem.groups.empty() || random.chance(0.5)) return problem;
  for (std::uint32_t& group : problem.groups) group = std::numeric_limits<std::uint32_t>::max() - 1000 * group;
  problem.plain.groups.count = std::size_t{1} << 32U;
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
  }
  while (answer.size() < problem.plain.budget) {
    for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
      if (taken[problem.group_of(i)] >= problem.room()) oracle.exclude(i);
    }
    const std::size_t best = oracle.best();
    if (best == oracle.size()) break;
    take(best);
  }
  return answer;
}

// Required candidates come first, in the order of their indices.
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

TEST(Constraints, every_strategy_keeps_to_them_also_without_time) {
  for_each_trial(300, [](Random& random) {
    Problem problem = random_problem(random, 100);
    problem.plain.stochastic.seed = random.seed();
    problem.plain.certificate = random.chance(0.5);
    problem.plain.time_limit = random.chance(0.5) ? 1e-9 : 0;
    Selector selector(problem.capacity());
    for (const Strategy strategy : strategies) {
      SCOPED_TRACE(to_string(strategy));
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      expect_sound(problem, selection);
      for (std::size_t j = 0; j < problem.required_count(); ++j) EXPECT_TRUE(problem.is_required(selection.indices[j]));
    }
  });
}

Problem small_problem_of_groups(Random& random) {
  const auto n = static_cast<std::size_t>(random.integer(2, 11));
  Problem problem = problem_of(awkward_blocks(random, n), 1 + random.index(n));
  const int count = random.integer(1, 4);
  problem.plain.groups.count = static_cast<std::size_t>(count);
  problem.plain.groups.maximum = 1 + random.index(2);
  for (std::size_t i = 0; i < n; ++i) {
    problem.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
  }
  problem.plain.certificate = true;
  problem.set_prior(Matrix6::Identity());
  return problem;
}

// The guarantee of greedy over a matroid, against every feasible subset. The prior's log det is 0.
TEST(Constraints, greedy_reaches_at_least_half_of_the_optimum) {
  for_each_trial(300, [&](Random& random) {
    const Problem problem = small_problem_of_groups(random);
    const long double optimum = Optimum(problem, true).of(problem.plain.budget);
    Selector selector(problem.capacity());
    const Selection selection = selector.select(problem.blocks, problem.options());
    EXPECT_GE(selection.log_det, optimum / 2 - 1e-9L);
    EXPECT_LE(selection.log_det, optimum + 1e-9L);
    EXPECT_GE(selection.upper_bound, optimum - 1e-12L);
  });
}

// Ten candidates and an invalid one, of which four are required, each in a group.
TEST(Constraints, that_cannot_be_met_are_named) {
  using Flags = std::vector<unsigned char>;
  using Groups = std::vector<std::uint32_t>;
  const Flags four = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0}, four_and_invalid = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 1};
  const Groups one(11, 0), two = {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
  const struct {
    const char* why;
    std::size_t budget;
    Flags required;
    Groups groups;
    std::size_t count, maximum;
    const char* reason;
  } cases[] = {{"just within the budget", 4, four, {}, 0, 1, "ok"},
               {"more required than the budget", 3, four, {}, 0, 1, "infeasible"},
               {"required and invalid", 5, four_and_invalid, {}, 0, 1, "infeasible"},
               {"nothing is required", 3, Flags(11, 0), {}, 0, 1, "ok"},
               {"group 0 of 0", 4, four, one, 0, 1, "invalid_groups"},
               {"more required than a group allows", 4, four, one, 1, 3, "infeasible"},
               {"no more may be selected", 4, four, one, 1, 4, "all_selected"},
               {"group 1 of 1", 4, four, two, 1, 4, "invalid_groups"},
               {"as many groups as the capacity", 4, four, two, 20, 4, "ok"},
               {"more groups than the capacity", 4, four, two, std::size_t{1} << 40U, 4, "ok"},
               {"as many as group 0 may have, and one of group 1", 6, four, two, 20, 4, "all_selected"},
               {"groups without room", 4, Flags(11, 0), two, 2, 0, "all_selected"}};
  Random random;
  Problem problem = problem_of(random_store(random, 10, 1, 2), 0);
  problem.blocks.push_back_invalid();
  Selector selector(20);
  for (const auto& of : cases) {
    SCOPED_TRACE(of.why);
    problem.plain.budget = of.budget;
    problem.required = of.required;
    problem.groups = of.groups;
    problem.plain.groups.count = of.count;
    problem.plain.groups.maximum = of.maximum;
    const Selection selection = selector.select(problem.blocks, problem.options());
    EXPECT_STREQ(selection.reason(), of.reason);
    EXPECT_EQ(selection.has_answer(), selection.error == Error::none);
    EXPECT_TRUE(selection.has_answer() || selection.size == 0);
  }
}

}  // namespace
}  // namespace maxlogdet::test
