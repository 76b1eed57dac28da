// SPDX-License-Identifier: MIT
// Required and excluded candidates, and groups with a maximum each.
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace maxlogdet::test {
namespace {

constexpr Strategy greedy_strategies[] = {Strategy::greedy, Strategy::lazy_greedy};

// Feasible, with any subset of the constraints.
Problem random_constraints(Random& random, BlockStore blocks, int max_groups = 12) {
  Problem made;
  made.blocks = std::move(blocks);
  const std::size_t n = made.blocks.size();
  const bool has_groups = random.chance(0.7);
  if (has_groups) {
    const int count = random.integer(1, max_groups);
    for (int g = 0; g < count; ++g) made.maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 5)));
    for (std::size_t i = 0; i < n; ++i) made.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
  }
  if (random.chance(0.6)) {
    made.excluded.resize(n);
    for (unsigned char& flag : made.excluded) flag = random.chance(0.2) ? 7 : 0;
  }
  std::size_t required = 0;
  if (random.chance(0.6)) {
    made.required.resize(n);
    std::map<std::uint32_t, std::size_t> taken;
    for (std::size_t i = 0; i < n; ++i) {
      const bool has_room = !has_groups || taken[made.groups[i]] < made.maxima[made.groups[i]];
      if (made.is_excluded(i) || !has_room || !made.blocks.is_valid(i) || !random.chance(0.05)) continue;
      made.required[i] = 1;
      ++required;
      if (has_groups) ++taken[made.groups[i]];
    }
  }
  made.plain.budget = required + static_cast<std::size_t>(random.integer(0, static_cast<int>(n - required)));
  return made;
}

// Greedy over the partition matroid, from scratch.
std::vector<std::uint32_t> oracle_of(const Problem& problem) {
  GreedyOracle<double> oracle(problem.blocks);
  std::vector<std::uint32_t> answer;
  std::vector<std::size_t> taken(problem.maxima.size());
  const auto take = [&](std::size_t i) {
    oracle.take(i);
    answer.push_back(static_cast<std::uint32_t>(i));
    if (!problem.groups.empty()) ++taken[problem.groups[i]];
  };
  for (std::size_t i = 0; i < problem.required.size(); ++i) {
    if (problem.required[i] != 0) take(i);
  }
  for (std::size_t i = 0; i < problem.excluded.size(); ++i) {
    if (problem.excluded[i] != 0) oracle.exclude(i);
  }
  while (answer.size() < problem.plain.budget) {
    for (std::size_t i = 0; i < problem.groups.size(); ++i) {
      if (taken[problem.groups[i]] >= problem.maxima[problem.groups[i]]) oracle.exclude(i);
    }
    const std::size_t best = oracle.best();
    if (best == oracle.size()) break;
    take(best);
  }
  return answer;
}

// Whatever the strategy, an answer keeps to them.
void expect_kept(const Problem& problem, const Selection& selection) {
  ASSERT_TRUE(selection.has_answer()) << to_string(selection.status);
  ASSERT_LE(selection.size, problem.plain.budget);
  const std::set<std::uint32_t> chosen(selection.begin(), selection.end());
  ASSERT_EQ(chosen.size(), selection.size);
  std::map<std::uint32_t, std::size_t> taken;
  std::set<std::uint32_t> could_be_added;
  for (std::uint32_t i = 0; i < problem.blocks.size(); ++i) {
    const bool is_chosen = chosen.count(i) > 0;
    if (is_chosen && !problem.groups.empty()) ++taken[problem.groups[i]];
    if (is_chosen) {
      EXPECT_TRUE(problem.blocks.is_valid(i));
    }
    if (problem.is_excluded(i)) {
      EXPECT_FALSE(is_chosen) << i << " is excluded";
    } else if (!is_chosen && problem.blocks.is_valid(i)) {
      could_be_added.insert(i);
    }
    if (problem.is_required(i)) {
      EXPECT_TRUE(is_chosen) << i << " is required";
    }
  }
  for (const auto& [group, count] : taken) EXPECT_LE(count, problem.maxima[group]) << "group " << group;
  for (const std::uint32_t i : could_be_added) {
    const bool has_room = problem.groups.empty() || taken[problem.groups[i]] < problem.maxima[problem.groups[i]];
    EXPECT_FALSE(has_room && selection.size < problem.plain.budget) << i << " could be added";
  }
  if (selection.status != Status::deadline_reached) {
    EXPECT_EQ(selection.status == Status::ok,
              selection.size == problem.plain.budget && selection.status != Status::all_selected);
  }
  EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(problem.blocks, indices_of(selection))), 1e-8);
}

BlockStore random_store(Random& random, std::size_t n) {
  BlockStore blocks;
  for (std::size_t i = 0; i < n; ++i) {
    if (random.chance(0.03)) {
      blocks.push_back_invalid();
    } else {
      push_back(blocks, random_block(random, random.integer(1, 3)));
    }
  }
  return blocks;
}

TEST(Constraints, greedy_equals_the_oracle) {
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Problem problem =
        random_constraints(random, random_store(random, static_cast<std::size_t>(random.integer(1, 150))));
    const std::vector<std::uint32_t> expected = oracle_of(problem);
    Selector selector(problem.blocks.size());
    for (const Strategy strategy : greedy_strategies) {
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      expect_kept(problem, selection);
      ASSERT_EQ(indices_of(selection), expected) << to_string(strategy);
    }
  }
}

TEST(Constraints, lazy_greedy_equals_greedy_on_frames) {
  for_every_family(1000, [&](const BlockStore& blocks) {
    Random random(blocks.size());
    Problem problem = random_constraints(random, blocks, 60);
    problem.plain.budget = std::max<std::size_t>(problem.plain.budget, 100);
    Selector selector(1000);
    const auto greedy = indices_of(selector.select(blocks, problem.options(Strategy::greedy)));
    const Selection lazy = selector.select(blocks, problem.options(Strategy::lazy_greedy));
    EXPECT_EQ(indices_of(lazy), greedy);
    expect_kept(problem, lazy);
  });
}

TEST(Constraints, every_strategy_keeps_to_them_or_says_that_it_cannot) {
  for (std::uint64_t variation = 0; variation < trials(200); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Problem problem =
        random_constraints(random, random_store(random, static_cast<std::size_t>(random.integer(1, 100))));
    Selector selector(problem.blocks.size());
    for (const Strategy strategy : sim::strategies) {
      SCOPED_TRACE(to_string(strategy));
      Options options = problem.options(strategy);
      options.stochastic.seed = variation;
      options.certificate.compute = random.chance(0.5);
      options.exchange.sweeps = random.chance(0.5) ? 2 : 0;
      options.time_limit = random.chance(0.5) ? 1e-9 : 0;
      const Selection selection = selector.select(problem.blocks, options);
      if (selection.error == Error::unsupported_groups) {
        EXPECT_NE(options.groups.ids, nullptr);
        EXPECT_FALSE(strategy == Strategy::greedy || strategy == Strategy::lazy_greedy ||
                     strategy == Strategy::stochastic_greedy || strategy == Strategy::automatic);
        continue;
      }
      expect_kept(problem, selection);
      if (options.certificate.compute) {
        EXPECT_GE(selection.upper_bound, selection.log_det);
      }
    }
  }
}

// Over the prior, whose log det is 0, of every subset that groups and budget allow.
long double optimum_of(const Problem& problem) {
  const std::size_t n = problem.blocks.size();
  long double optimum = 0;
  for (std::uint32_t subset = 0; subset < 1U << n; ++subset) {
    std::vector<std::uint32_t> indices;
    std::vector<std::size_t> taken(problem.maxima.size());
    bool is_feasible = true;
    for (std::uint32_t i = 0; i < n; ++i) {
      if ((subset >> i & 1U) == 0) continue;
      indices.push_back(i);
      is_feasible = is_feasible && ++taken[problem.groups[i]] <= problem.maxima[problem.groups[i]];
    }
    if (!is_feasible || indices.size() > problem.plain.budget) continue;
    optimum = std::max(optimum, log_det_of(problem.blocks, indices, problem.information()));
  }
  return optimum;
}

Problem small_problem_of_groups(Random& random) {
  Problem problem;
  const auto n = static_cast<std::size_t>(random.integer(2, 11));
  problem.blocks = awkward_blocks(random, n);
  const int count = random.integer(1, 4);
  for (int g = 0; g < count; ++g) problem.maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 2)));
  for (std::size_t i = 0; i < n; ++i) {
    problem.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
  }
  problem.plain.budget = static_cast<std::size_t>(random.integer(1, static_cast<int>(n)));
  problem.plain.certificate.compute = true;
  problem.set_prior(Matrix6::Identity());
  return problem;
}

// The guarantee of greedy over a matroid, against every feasible subset.
TEST(Constraints, greedy_reaches_at_least_half_of_the_optimum) {
  double worst = 1;
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Problem problem = small_problem_of_groups(random);
    const long double optimum = optimum_of(problem);
    Selector selector(problem.blocks.size());
    for (const Strategy strategy : greedy_strategies) {
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      ASSERT_GE(selection.log_det, optimum / 2 - 1e-9L);
      ASSERT_LE(selection.log_det, optimum + 1e-9L);
      if (!std::isnan(selection.upper_bound)) {
        ASSERT_GE(selection.upper_bound, optimum - 1e-12L);
      }
      if (optimum > 0) worst = std::min(worst, static_cast<double>(selection.log_det / optimum));
    }
  }
  std::printf("worst greedy / optimum over groups: %.3f (guaranteed 0.5)\n", worst);
}

TEST(Constraints, required_come_first_in_the_order_of_their_indices) {
  Random random;
  const BlockStore blocks = random_store(random, 50);
  std::vector<unsigned char> required(50);
  std::vector<std::uint32_t> expected;
  for (const std::uint32_t i : {3U, 17U, 40U}) {
    if (!blocks.is_valid(i)) continue;
    required[i] = 1;
    expected.push_back(i);
  }
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
    Options options;
    options.strategy = strategy;
    options.budget = 10;
    options.required = required.data();
    std::vector<std::uint32_t> indices = select_indices(blocks, options);
    ASSERT_EQ(indices.size(), 10U);
    indices.resize(expected.size());
    EXPECT_EQ(indices, expected) << to_string(strategy);
  }
}

TEST(Constraints, one_maximum_for_all_groups) {
  Random random;
  const BlockStore blocks = random_store(random, 60);
  std::vector<std::uint32_t> groups(60);
  for (std::uint32_t i = 0; i < 60; ++i) groups[i] = i % 6;
  Options options;
  options.budget = 60;
  options.groups.ids = groups.data();
  options.groups.count = 6;
  for (const std::size_t maximum : {0U, 1U, 4U, 1000U}) {
    options.groups.maximum = maximum;
    std::map<std::uint32_t, std::size_t> taken;
    const auto indices = select_indices(blocks, options);
    for (const std::uint32_t i : indices) ++taken[groups[i]];
    for (const auto& [group, count] : taken) EXPECT_LE(count, maximum);
    EXPECT_EQ(indices.size(), maximum == 1000 ? 60 - blocks.invalid_count() : 6 * maximum);
  }
}

// Groups may be numbered as objects or the cells of a fine grid are, beyond the selector's capacity: the answer is that
// of the same groups numbered from 0 on.
TEST(Constraints, groups_may_have_any_numbers) {
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const std::size_t n = static_cast<std::size_t>(random.integer(1, 60));
    Problem problem = random_constraints(random, random_store(random, n));
    if (problem.groups.empty()) continue;
    Problem renamed = problem;
    const bool has_maxima = random.chance(0.5);
    if (has_maxima) {
      constexpr std::uint32_t step = 7919;
      renamed.maxima.assign(problem.maxima.size() * step, 77);
      for (std::size_t g = 0; g < problem.maxima.size(); ++g) renamed.maxima[(g + 1) * step - 1] = problem.maxima[g];
      for (std::uint32_t& group : renamed.groups) group = (group + 1) * step - 1;
    } else {
      for (std::uint32_t& group : renamed.groups) group = std::numeric_limits<std::uint32_t>::max() - 1000 * group;
    }
    Selector selector(problem.blocks.size());
    Selector other(problem.blocks.size());
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
      Options options = problem.options(strategy);
      Options options_renamed = renamed.options(strategy);
      for (Options* const one : {&options, &options_renamed}) {
        one->exchange.sweeps = 2;
        one->certificate.compute = true;
        if (has_maxima) continue;
        one->groups.maxima = nullptr;
        one->groups.maximum = 3;
        one->required = nullptr;  // more of them may be in a group
      }
      if (!has_maxima) options_renamed.groups.count = std::size_t{1} << 32U;
      const Selection expected = selector.select(problem.blocks, options);
      const Selection selection = other.select(renamed.blocks, options_renamed);
      EXPECT_EQ(selection.status, expected.status);
      EXPECT_EQ(indices_of(selection), indices_of(expected)) << to_string(strategy);
      EXPECT_EQ(selection.upper_bound, expected.upper_bound);
    }
  }
}

TEST(Constraints, everything_excluded_leaves_nothing) {
  Random random;
  const BlockStore blocks = random_store(random, 30);
  const std::vector<unsigned char> excluded(30, 1);
  for (const Strategy strategy : sim::strategies) {
    Options options;
    options.strategy = strategy;
    options.budget = 10;
    options.excluded = excluded.data();
    Selector selector(30);
    const Selection selection = selector.select(blocks, options);
    EXPECT_EQ(selection.status, Status::all_selected) << to_string(strategy);
    EXPECT_EQ(selection.size, 0U);
  }
}

}  // namespace
}  // namespace maxlogdet::test
