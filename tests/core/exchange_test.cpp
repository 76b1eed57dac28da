// SPDX-License-Identifier: MIT
// Exchange: the textbook's swaps, log det that never falls, and nothing left to swap.
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace maxlogdet::test {
namespace {

constexpr std::size_t until_done = 100;  // sweeps; a handful is enough

Options with_sweeps(Strategy strategy, std::size_t budget, std::size_t sweeps) {
  Options options = with_budget(budget, strategy);
  options.exchange.sweeps = sweeps;
  return options;
}

// An oracle that holds the answer without the candidate at `place`.
GreedyOracle<long double> without(const BlockStore& blocks, const std::vector<std::uint32_t>& indices,
                                  std::size_t place, const Matrix6& prior = default_information()) {
  GreedyOracle<long double> oracle(blocks, prior);
  for (std::size_t j = 0; j < indices.size(); ++j) {
    if (j != place) oracle.take(indices[j]);
  }
  return oracle;
}

// Sweeps over an answer as plainly as possible; a swap that gains no more than this is not made.
constexpr long double negligible = 1e-7L;
std::vector<std::uint32_t> textbook_exchange(const BlockStore& blocks, std::vector<std::uint32_t> indices,
                                             std::size_t sweeps) {
  std::set<std::uint32_t> selected(indices.begin(), indices.end());
  for (std::size_t sweep = 0; sweep < sweeps; ++sweep) {
    const auto before = indices;
    for (std::size_t place = 0; place < indices.size(); ++place) {
      const auto oracle = without(blocks, indices, place);
      long double best_gain = oracle.gain(indices[place]) + negligible;
      std::uint32_t best = indices[place];
      for (std::uint32_t i = 0; i < blocks.size(); ++i) {
        if (selected.count(i) != 0 || !blocks.is_valid(i)) continue;
        const long double gain = oracle.gain(i);
        if (gain > best_gain) {
          best_gain = gain;
          best = i;
        }
      }
      selected.erase(indices[place]);
      selected.insert(best);
      indices[place] = best;
    }
    if (indices == before) break;
  }
  return indices;
}

// Whether exchanges changed greedy's answer, as the textbook's do.
bool changes_as_the_textbook(const BlockStore& blocks, std::size_t budget, std::size_t sweeps) {
  SCOPED_TRACE("budget " + std::to_string(budget) + ", sweeps " + std::to_string(sweeps));
  const auto greedy = select_indices(blocks, with_sweeps(Strategy::greedy, budget, 0));
  const auto exchanged = select_indices(blocks, with_sweeps(Strategy::greedy, budget, sweeps));
  EXPECT_EQ(exchanged, textbook_exchange(blocks, greedy, sweeps));
  return exchanged != greedy;
}

TEST(Exchange, equals_the_textbook_on_every_family) {
  std::size_t improved = 0;
  for_every_family(60, [&](const BlockStore& blocks) {
    for (const std::size_t budget : {3U, 8U, 15U}) {
      for (const std::size_t sweeps : {std::size_t{1}, std::size_t{2}, until_done}) {
        improved += changes_as_the_textbook(blocks, budget, sweeps) ? 1U : 0U;
      }
    }
  });
  EXPECT_GT(improved, trials(30));
}

TEST(RealFrames, exchange_equals_the_textbook) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(17, [](const BlockStore& blocks) { changes_as_the_textbook(blocks, 8, 2); });
}

// What may take a place gains no more in it, by more than rounding could explain where rows are a thousand times longer
// than others.
void expect_nothing_left_to_swap(const Problem& problem, const std::vector<std::uint32_t>& indices) {
  const std::set<std::uint32_t> selected(indices.begin(), indices.end());
  std::map<std::uint32_t, std::size_t> members;
  for (const std::uint32_t i : indices) ++members[problem.group_of(i)];
  for (std::size_t place = problem.required_count(); place < indices.size(); ++place) {
    const auto oracle = without(problem.blocks, indices, place, problem.information());
    const long double kept = oracle.gain(indices[place]);
    for (std::uint32_t i = 0; i < problem.blocks.size(); ++i) {
      if (selected.count(i) != 0 || !problem.is_free(i)) continue;
      const std::uint32_t group = problem.group_of(i);
      const std::size_t left = members[group] - (group == problem.group_of(indices[place]) ? 1 : 0);
      if (left >= problem.room_of(group)) continue;
      ASSERT_LE(oracle.gain(i), kept + 1e-5L) << i << " for " << indices[place];
    }
  }
}

// By any strategy, against any prior and under any constraints.
TEST(Exchange, never_lowers_log_det_and_ends_where_nothing_is_left_to_swap) {
  std::size_t changed = 0;
  for_each_trial(700, [&](Random& random) {
    Problem problem = problem_of(awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 80))), 0);
    constrain(random, problem);
    problem.plain.budget = std::min<std::size_t>(problem.plain.budget, problem.required_count() + 25);
    if (random.chance(0.5)) problem.set_prior(random_prior(random));
    Selector selector(problem.capacity());
    for (const Strategy strategy : strategies) {
      SCOPED_TRACE(to_string(strategy));
      problem.plain.exchange.sweeps = 0;
      const Selection first = selector.select(problem.blocks, problem.options(strategy));
      if (first.error == Error::unsupported_groups) continue;
      const auto before = indices_of(first);
      for (const std::size_t sweeps : {static_cast<std::size_t>(random.integer(1, 5)), until_done}) {
        problem.plain.exchange.sweeps = sweeps;
        const Selection selection = selector.select(problem.blocks, problem.options(strategy));
        const auto after = indices_of(selection);
        changed += after != before ? 1U : 0U;
        ASSERT_EQ(after.size(), before.size());
        expect_sound(problem, selection, 1e-6);
        EXPECT_GE(log_det_of(problem.blocks, after, problem.information()),
                  log_det_of(problem.blocks, before, problem.information()));
        if (sweeps < until_done || strategy != strategies[problem.blocks.size() % 3]) continue;
        const auto required = static_cast<std::ptrdiff_t>(problem.required_count());
        EXPECT_TRUE(std::equal(before.begin(), before.begin() + required, after.begin()));
        expect_nothing_left_to_swap(problem, after);
      }
    }
  });
  EXPECT_GT(changed, trials(250));
}

TEST(Exchange, never_lowers_log_det_at_any_scale_or_among_near_copies) {
  for_each_exponent(-30, 30, [](Random& random, int exponent) {
    BlockStore blocks = random_store(random, 40, std::pow(10.0, exponent), 2);
    for (std::size_t i = 0; i < 40; ++i) {
      Block block = stored_block(blocks, i);
      block(0, 0) = static_cast<double>(std::nextafter(static_cast<float>(block(0, 0)), 1e38F));
      push_back(blocks, block);
    }
    for (const std::size_t budget : {1U, 2U, 5U, 12U}) {
      const auto before = select_indices(blocks, with_sweeps(Strategy::stochastic_greedy, budget, 0));
      const auto after = select_indices(blocks, with_sweeps(Strategy::stochastic_greedy, budget, 3));
      ASSERT_EQ(after.size(), budget);
      EXPECT_GE(log_det_of(blocks, after), log_det_of(blocks, before));
    }
  });
}

TEST(Exchange, has_nothing_to_do_where_all_or_none_are_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 20);
  Selector selector(64);
  EXPECT_EQ(selector.select(blocks, with_sweeps(Strategy::greedy, 0, 3)).status, Status::ok);
  const Selection all = selector.select(blocks, with_sweeps(Strategy::greedy, 30, 3));
  EXPECT_EQ(all.status, Status::all_selected);
  EXPECT_EQ(all.size, 20U);
  EXPECT_EQ(selector.select(BlockStore(), with_sweeps(Strategy::greedy, 5, 3)).status, Status::ok);
  const auto once = select_indices(blocks, with_sweeps(Strategy::greedy, 5, until_done));
  EXPECT_EQ(select_indices(blocks, with_sweeps(Strategy::greedy, 5, std::numeric_limits<std::size_t>::max())), once);
}

}  // namespace
}  // namespace maxlogdet::test
