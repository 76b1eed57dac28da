// SPDX-License-Identifier: MIT
// Required candidates, and groups with a maximum.
#include "tests/core/optimum.hpp"
#include "tests/core/targets.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

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
TEST(Constraints, every_strategy_keeps_to_them) {
  for_each_trial(200, [](Random& random) {
    Problem problem = random_problem(random, 100);
    problem.plain.stochastic.seed = random.seed();
    problem.plain.certificate = random.chance(0.5);
    problem.plain.time_limit = random.chance(0.5) ? 1e-9 : 0;
    std::vector<std::uint32_t> required;
    for (std::uint32_t i = 0; i < problem.blocks.size(); ++i) {
      if (problem.is_required(i)) required.push_back(i);
    }
    Selector selector(problem.capacity());
    for (const Strategy strategy : strategies) {
      SCOPED_TRACE(to_string(strategy));
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      expect_sound(problem, selection);
      EXPECT_TRUE(std::equal(required.begin(), required.end(), selection.begin()));
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

TEST(Constraints, groups_have_up_to_their_maximum) {
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
    problem.plain.certificate = true;
    Problem renamed = problem;
    for (std::uint32_t& group : renamed.groups) group = std::numeric_limits<std::uint32_t>::max() - 1000 * group;
    renamed.plain.groups.count = std::size_t{1} << 32U;
    for (const Strategy strategy : strategies) {
      const Answer expected = answer_to(problem.blocks, problem.options(strategy));
      EXPECT_EQ(answer_to(problem.blocks, renamed.options(strategy)), expected);
    }
  });
}

// Ten candidates, an invalid one, and what is asked for. Four are required where constraints can be met.
struct Asked : Problem {
  Asked() {
    Random random;
    blocks = random_store(random, 10, 1, 2);
    blocks.push_back_invalid();
    plain.budget = 4;
    required = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0};
  }
};

std::string reason_of(const Problem& problem) {
  Selector selector(20);
  const Selection selection = selector.select(problem.blocks, problem.options());
  EXPECT_EQ(selection.has_answer(), selection.status == Status::ok || selection.status == Status::all_selected);
  EXPECT_TRUE(selection.has_answer() || selection.size == 0);
  return selection.reason();
}

TEST(Constraints, on_required_candidates_that_cannot_be_met_are_named) {
  Asked asked;
  EXPECT_EQ(reason_of(asked), "ok");
  asked.plain.budget = 3;
  EXPECT_EQ(reason_of(asked), "infeasible") << "more required than the budget";
  asked.plain.budget = 5;
  asked.required[10] = 1;
  EXPECT_EQ(reason_of(asked), "infeasible") << "required and invalid";
  asked.required.assign(11, 0);
  EXPECT_EQ(reason_of(asked), "ok") << "nothing is required";
}

TEST(Constraints, on_groups_that_cannot_be_met_are_named) {
  Asked asked;
  asked.groups.resize(11);
  GroupOptions& options = asked.plain.groups;
  EXPECT_EQ(reason_of(asked), "invalid_groups") << "group 0 of 0";
  options.count = 1;
  options.maximum = 3;
  EXPECT_EQ(reason_of(asked), "infeasible") << "more required than a group allows";
  options.maximum = 4;
  EXPECT_EQ(reason_of(asked), "all_selected") << "no more may be selected";
  asked.groups[9] = 1;
  EXPECT_EQ(reason_of(asked), "invalid_groups") << "group 1 of 1";
  for (const std::size_t many : {std::size_t{20}, std::size_t{21}, std::size_t{1} << 40U}) {
    options.count = many;
    EXPECT_EQ(reason_of(asked), "ok") << many << ", also more groups than the capacity";
  }
  asked.plain.budget = 6;
  EXPECT_EQ(reason_of(asked), "all_selected") << "four required, as many as group 0 may have, and one of group 1";
}

}  // namespace
}  // namespace maxlogdet::test
