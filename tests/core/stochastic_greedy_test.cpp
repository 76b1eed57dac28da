// SPDX-License-Identifier: MIT
// Samples: how many, which, and what is taken of each.
#include "kernel/base/counter_random.hpp"
#include "kernel/blocks/candidates.hpp"
#include "tests/core/factors.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

Options stochastic(std::size_t budget, double epsilon, std::uint64_t seed) {
  Options options = with_budget(budget, Strategy::stochastic_greedy);
  options.stochastic.epsilon = epsilon;
  options.stochastic.seed = seed;
  return options;
}

TEST(StochasticGreedy, evaluates_s_candidates_a_round) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 500);
  Selector selector(500);
  for (const std::size_t k : {10U, 50U, 250U}) {
    for (const double epsilon : {0.5, 0.1, 0.01}) {
      const auto s = static_cast<std::size_t>(std::ceil(500.0 / static_cast<double>(k) * std::log(1 / epsilon)));
      std::size_t expected = 0;  // capped by what remains
      for (std::size_t round = 0; round < k; ++round) expected += std::min(s, 500 - round);
      EXPECT_EQ(selector.select(blocks, stochastic(k, epsilon, 7)).evaluations, expected) << k << ' ' << epsilon;
    }
  }
}

// The best of a sample of equal candidates is its lowest index: with s distinct ones out of n it is i with probability
// C(n - 1 - i, s - 1) / C(n, s).
TEST(StochasticGreedy, samples_are_distinct_and_all_subsets_equally_likely) {
  constexpr int n = 40;
  constexpr int s = 5;
  const BlockStore blocks = copies_of(Block::Zero(2, 6), n);
  Selector selector(n);
  std::vector<int> lowest(n, 0);
  constexpr int runs = 20000;
  for (int run = 0; run < runs; ++run) {
    const Selection selection =
        selector.select(blocks, stochastic(1, std::exp(-4.8 / n), static_cast<std::uint64_t>(run)));
    ASSERT_EQ(selection.evaluations, static_cast<std::size_t>(s));
    ++lowest[selection.indices[0]];
  }
  const auto choose = [](int from, int count) {
    double result = 1;
    for (int j = 0; j < count; ++j) result *= static_cast<double>(from - j) / (j + 1);
    return result;
  };
  for (int i = 0; i < n; ++i) {
    const double probability = choose(n - 1 - i, s - 1) / choose(n, s);
    EXPECT_NEAR(lowest[static_cast<std::size_t>(i)], runs * probability, 5 * std::sqrt(runs * probability) + 1) << i;
  }
}

// Far outliers and near copies, all of `rows` rows.
BlockStore outliers_and_near_copies(Random& random, int rows) {
  std::vector<Block> bases;
  for (int i = 0; i < 10; ++i) {
    bases.push_back(random_block(random, rows, random.chance(0.3) ? std::pow(10.0, random.uniform(0, 6)) : 1));
  }
  return store_of(300,
                  [&](std::size_t i) { return Block(bases[i % bases.size()] * (1 + 1e-7 * random.integer(-3, 3))); });
}

// The place of the largest of `relative_gains`, on ties that of the lowest candidate.
std::uint32_t place_of_best(const std::vector<double>& relative_gains, const std::vector<Candidate>& candidates) {
  std::uint32_t best = 0;
  for (std::uint32_t j = 1; j < relative_gains.size(); ++j) {
    const bool is_first = relative_gains[j] == relative_gains[best] && candidates[j] < candidates[best];
    if (relative_gains[j] > relative_gains[best] || is_first) best = j;
  }
  return best;
}

// The same draws, and of each sample what float64 says is best.
TEST(StochasticGreedy, takes_what_float64_finds_best_in_each_sample) {
  const simd::Kernel& kernel = *simd::built_in()[0];
  for_each_trial(300, [&](Random& random) {
    const int rows = random.integer(1, 3);
    const BlockStore blocks = outliers_and_near_copies(random, rows);
    const std::uint64_t seed = random.seed();
    const std::size_t budget = 20;
    const auto selected = select_indices(blocks, stochastic(budget, 0.1, seed));
    ASSERT_EQ(selected.size(), budget);

    const auto n = static_cast<std::uint32_t>(blocks.size());
    const auto s = static_cast<std::uint32_t>(std::ceil(n / 20.0 * std::log(10.0)));
    std::vector<Candidate> pool;
    for (std::uint32_t i = 0; i < n; ++i) pool.push_back(static_cast<Candidate>(i));
    CounterRandom draws(seed);
    InformationFactor factor = factor_of(default_information(blocks));
    for (std::size_t round = 0; round < budget; ++round) {
      const auto remaining = static_cast<std::uint32_t>(n - round);
      for (std::uint32_t j = 0; j < s; ++j) std::swap(pool[j], pool[j + draws.below(remaining - j)]);
      std::vector<double> relative_gains(s);
      kernel.exact[rows - 1].decide(all_of(blocks, kernel).planes, factor.inverse(), pool.data(), s,
                                    relative_gains.data());
      const std::uint32_t best = place_of_best(relative_gains, pool);
      ASSERT_EQ(selected[round], simd::number(pool[best])) << "round " << round;
      add(factor, stored_block(blocks, simd::number(pool[best])));
      pool[best] = pool[remaining - 1];
    }
  });
}

TEST(StochasticGreedy, same_seed_same_answer_and_other_seeds_differ) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 300);
  std::set<std::vector<std::uint32_t>> answers;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto answer = select_indices(blocks, stochastic(20, 0.1, seed));
    EXPECT_EQ(select_indices(blocks, stochastic(20, 0.1, seed)), answer);
    answers.insert(answer);
  }
  EXPECT_EQ(answers.size(), 20U);
}

TEST(StochasticGreedy, with_a_sample_of_everything_is_greedy) {
  for_each_trial(50, [](Random& random) {
    const BlockStore blocks = awkward_blocks(random, 80);
    EXPECT_EQ(select_indices(blocks, stochastic(20, 1e-300, random.seed())),
              select_indices(blocks, with_budget(20, Strategy::greedy)));
  });
}

TEST(CounterRandom, is_uniform_and_stays_below_its_range) {
  CounterRandom random(3);
  std::vector<int> counts(10, 0);
  constexpr int draws = 100000;
  for (int i = 0; i < draws; ++i) ++counts.at(random.below(10));
  for (const int count : counts) EXPECT_NEAR(count, draws / 10.0, 5 * std::sqrt(draws * 0.09));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(random.below(1), 0U);
}

}  // namespace
}  // namespace maxlogdet::test
