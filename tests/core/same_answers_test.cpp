// SPDX-License-Identifier: MIT
// The same answer, bit for bit, on every instruction set and from a selector that has been used before: for every
// strategy and whatever else is asked for. threading_test.cpp has the same of threads.
#include "tests/support/answer.hpp"
#include "tests/support/flushed_denormals.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

// Every strategy as it is, and without any time; lazy greedy with a certificate and targets.
std::vector<Options> requests_for(std::size_t budget) {
  std::vector<Options> requests;
  for (const Strategy strategy : strategies) {
    for (const double limit : {0.0, 1e-9}) {
      requests.push_back(with_budget(budget, strategy));
      requests.back().time_limit = limit;
    }
  }
  const Options lazy = with_budget(budget, Strategy::lazy_greedy);
  for (const std::size_t k : {std::size_t{6}, std::size_t{20}, budget}) {
    requests.push_back(lazy);
    requests.back().budget = k;
    requests.back().certificate = true;
  }
  requests.push_back(lazy);
  requests.back().target.efficiency = 0.2;
  requests.push_back(lazy);
  requests.back().target.translation_sigma = requests.back().target.rotation_sigma = 0.02;
  return requests;
}

TEST(SameAnswers, on_every_isa) {
  for_every_family(3000, [&](const BlockStore& blocks) {
    for (const Options& options : requests_for(100)) {
      SCOPED_TRACE(to_string(options.strategy));
      same_on_every_isa([&] { return answer_to(blocks, options); });
    }
  });
}

// So many that lazy rounds are split between threads.
TEST(SameAnswers, on_every_isa_and_number_of_threads_for_many_candidates) {
  PoolExecutor pool(3);
  for_every_family(6000, [&](const BlockStore& blocks) {
    Options options = with_budget(100, Strategy::lazy_greedy);
    const auto select = [&] { return answer_to(blocks, options, &pool); };
    const Answer expected = same_on_every_isa(select);
    options.threads = 3;
    EXPECT_EQ(same_on_every_isa(select), expected);
  });
}

// Blocks of any scale, every second time with an outlier, which requires rounds in float64 until it is selected.
BlockStore scaled_blocks(Random& random) {
  const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(20, 600)));
  const double scale = std::pow(10, random.uniform(-3, 3));
  BlockStore blocks;
  if (random.chance(0.5)) push_back(blocks, 1e5 * scale * random_block(random, 2));
  for (std::size_t i = 0; i < made.size(); ++i) push_back(blocks, Block(scale * stored_block(made, i)));
  return blocks;
}

TEST(SameAnswers, whatever_a_selector_selected_before) {
  Selector used(700);
  for_each_trial(300, [&](Random& random) {
    const BlockStore blocks = scaled_blocks(random);
    Options options =
        with_budget(static_cast<std::size_t>(random.integer(1, 20)), strategies[random.index(std::size(strategies))]);
    options.certificate = true;
    const Answer expected = answer_to(blocks, options);
    const Answer answer = used.select(blocks, options);
    EXPECT_EQ(answer, expected);
    EXPECT_EQ(answer.evaluations, expected.evaluations);
    EXPECT_EQ(answer.float64_decisions, expected.float64_decisions);
  });
}

// Targets, on information of any condition number, and with denormals flushed.
TEST(SameAnswers, to_targets_on_every_isa_and_number_of_threads) {
  PoolExecutor pool(3);
  int stopped = 0;
  for_each_trial(150, [&](Random& random) {
    const std::size_t n = random.chance(0.1) ? 12000 : 300;
    const BlockStore blocks = random.chance(1.0 / 3) ? ill_conditioned_blocks(random, n) : any_blocks(random, n);
    Options options = with_budget(60, strategies[random.index(std::size(strategies))]);
    options.target.efficiency = random.uniform(0.01, 0.6);
    if (random.chance(0.5)) options.target.translation_sigma = std::pow(10.0, random.uniform(-4, 2));
    if (random.chance(0.5)) options.target.rotation_sigma = std::pow(10.0, random.uniform(-4, 2));
    const auto select = [&] { return answer_to(blocks, options, &pool); };
    const Answer expected = same_on_every_isa(select);
    stopped += expected.reason == "target_reached" ? 1 : 0;
    options.threads = 3;
    EXPECT_EQ(same_on_every_isa(select), expected);
    const FlushedDenormals flushed;
    EXPECT_EQ(select(), expected);
  });
  EXPECT_GT(stopped, 0);
}

}  // namespace
}  // namespace maxlogdet::test
