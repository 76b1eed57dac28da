// SPDX-License-Identifier: MIT
// Exchange: the textbook's swaps, log det that never falls, constraints, and the same answer on every machine.
#include "sim/hash.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
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
                                  std::size_t place, const Matrix6& prior) {
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
      const auto oracle = without(blocks, indices, place, default_information());
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

void expect_distinct_and_consistent(const BlockStore& blocks, const Selection& selection,
                                    const Matrix6& prior = default_information()) {
  EXPECT_EQ(std::set<std::uint32_t>(selection.begin(), selection.end()).size(), selection.size);
  expect_consistent(blocks, selection, 1e-6, prior);
}

TEST(Exchange, equals_the_textbook_on_every_family) {
  std::size_t improved = 0;
  for_every_family(60, [&](const BlockStore& blocks) {
    for (const std::size_t budget : {3U, 8U, 15U}) {
      for (const std::size_t sweeps : {std::size_t{1}, std::size_t{2}, until_done}) {
        SCOPED_TRACE("budget " + std::to_string(budget) + ", sweeps " + std::to_string(sweeps));
        const auto greedy = select_indices(blocks, with_sweeps(Strategy::greedy, budget, 0));
        const auto exchanged = select_indices(blocks, with_sweeps(Strategy::greedy, budget, sweeps));
        EXPECT_EQ(exchanged, textbook_exchange(blocks, greedy, sweeps));
        improved += exchanged != greedy ? 1U : 0U;
      }
    }
  });
  EXPECT_GT(improved, trials(30));
}

TEST(Exchange, never_lowers_log_det) {
  std::size_t changed = 0;
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 80)));
    const Matrix6 prior = random.chance(0.5) ? random_prior(random) : default_information();
    const EigenPrior eigen_prior(prior);
    for (const Strategy strategy : sim::strategies) {
      Options options = with_sweeps(strategy, static_cast<std::size_t>(random.integer(1, 25)), 0);
      options.prior = eigen_prior.data();
      Selector selector(100);
      const auto before = indices_of(selector.select(blocks, options));
      options.exchange.sweeps = static_cast<std::size_t>(random.integer(1, 5));
      const Selection selection = selector.select(blocks, options);
      const auto after = indices_of(selection);
      ASSERT_EQ(after.size(), before.size());
      EXPECT_GE(log_det_of(blocks, after, prior), log_det_of(blocks, before, prior));
      expect_distinct_and_consistent(blocks, selection, prior);
      changed += after != before ? 1U : 0U;
    }
  }
  EXPECT_GT(changed, trials(200));
}

TEST(Exchange, never_lowers_log_det_at_any_scale_or_among_near_copies) {
  for (int exponent = -30; exponent <= 30; exponent += 2) {
    Random random(static_cast<std::uint64_t>(exponent + 30));
    SCOPED_TRACE(random.name() + ", scale 1e" + std::to_string(exponent));
    BlockStore blocks;
    for (int i = 0; i < 40; ++i) push_back(blocks, random_block(random, 2, std::pow(10.0, exponent)));
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
  }
}

// Required and excluded candidates, and in 70 % of cases six groups.
Problem constrained_problem(Random& random) {
  Problem problem;
  const auto n = static_cast<std::size_t>(random.integer(10, 80));
  problem.blocks = awkward_blocks(random, n);
  problem.required.resize(n);
  problem.excluded.resize(n);
  problem.groups.resize(n);
  problem.maxima.resize(6);
  for (auto& group : problem.groups) group = static_cast<std::uint32_t>(random.integer(0, 5));
  for (auto& maximum : problem.maxima) maximum = static_cast<std::uint32_t>(random.integer(0, 3));
  auto places = problem.maxima;
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_required = random.chance(0.05) && places[problem.groups[i]] > 0;
    problem.required[i] = is_required ? 1 : 0;
    if (is_required) --places[problem.groups[i]];
    problem.excluded[i] = !is_required && random.chance(0.2) ? 1 : 0;
  }
  problem.plain.budget = 20;
  if (random.chance(0.7)) return problem;
  problem.groups.clear();
  problem.maxima.clear();
  return problem;
}

std::vector<std::uint32_t> count_by_group(const Problem& problem, const std::vector<std::uint32_t>& indices) {
  std::vector<std::uint32_t> counts(problem.maxima.size());
  for (const std::uint32_t i : indices) {
    if (!problem.groups.empty()) ++counts[problem.groups[i]];
  }
  return counts;
}

// What may take a place gains no more in it, by more than rounding could explain where rows are a thousand times longer
// than others.
void expect_nothing_left_to_swap(const Problem& problem, const std::vector<std::uint32_t>& indices, std::size_t first) {
  const std::set<std::uint32_t> selected(indices.begin(), indices.end());
  const std::vector<std::uint32_t> counts = count_by_group(problem, indices);
  for (std::size_t place = first; place < indices.size(); ++place) {
    const auto oracle = without(problem.blocks, indices, place, default_information());
    const long double kept = oracle.gain(indices[place]);
    for (std::uint32_t i = 0; i < problem.blocks.size(); ++i) {
      if (selected.count(i) != 0 || problem.is_excluded(i)) continue;
      if (!problem.groups.empty()) {
        const std::uint32_t group = problem.groups[i];
        const bool is_same_group = group == problem.groups[indices[place]];
        if (problem.maxima[group] == 0 || (counts[group] >= problem.maxima[group] && !is_same_group)) continue;
      }
      ASSERT_LE(oracle.gain(i), kept + 1e-5L) << i << " for " << indices[place];
    }
  }
}

TEST(Exchange, keeps_what_is_required_leaves_out_what_is_excluded_and_keeps_to_groups) {
  std::size_t changed = 0;
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Problem problem = constrained_problem(random);
    Options options = problem.options(sim::strategies[variation % 3]);
    Selector selector(100);
    const Selection first = selector.select(problem.blocks, options);
    if (!first.has_answer()) continue;  // more are required than 20
    const auto before = indices_of(first);
    options.exchange.sweeps = until_done;
    const Selection selection = selector.select(problem.blocks, options);
    const auto after = indices_of(selection);
    changed += after != before ? 1U : 0U;
    ASSERT_EQ(after.size(), before.size());
    const auto required = std::accumulate(problem.required.begin(), problem.required.end(), std::ptrdiff_t{0});
    EXPECT_TRUE(std::equal(before.begin(), before.begin() + required, after.begin()));
    for (const std::uint32_t i : after) EXPECT_FALSE(problem.is_excluded(i));
    const std::vector<std::uint32_t> counts = count_by_group(problem, after);
    for (std::size_t g = 0; g < counts.size(); ++g) EXPECT_LE(counts[g], problem.maxima[g]);
    EXPECT_GE(log_det_of(problem.blocks, after), log_det_of(problem.blocks, before));
    expect_distinct_and_consistent(problem.blocks, selection);
    expect_nothing_left_to_swap(problem, after, static_cast<std::size_t>(required));
  }
  EXPECT_GT(changed, trials(50));
}

TEST(Exchange, is_the_same_on_every_instruction_set) {
  for_every_family(500, [&](const BlockStore& blocks) {
    for (const std::size_t budget : {6U, 20U, 60U}) {
      std::vector<std::uint32_t> expected;
      for (const std::string& isa : sim::supported_isas()) {
        const ForcedIsa forced(isa.c_str());
        const auto indices = select_indices(blocks, with_sweeps(Strategy::lazy_greedy, budget, 3));
        if (expected.empty()) expected = indices;
        EXPECT_EQ(indices, expected) << isa;
      }
    }
  });
}

TEST(Exchange, stops_at_the_deadline_with_a_valid_answer_that_is_not_worse) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[3]);
  Selector selector(2000);
  Options options = with_sweeps(Strategy::stochastic_greedy, 60, 0);
  options.stochastic.epsilon = 0.9;
  const double before = selector.select(blocks, options).log_det;
  options.exchange.sweeps = until_done;
  bool was_cut = false;
  for (const double limit : {1e-4, 2e-4, 4e-4, 8e-4}) {
    options.time_limit = limit;
    const Selection selection = selector.select(blocks, options);
    ASSERT_TRUE(selection.has_answer());
    was_cut = was_cut || selection.status == Status::deadline_reached;
    EXPECT_EQ(selection.size, 60U);
    if (selection.searched == 60) {
      EXPECT_GE(selection.log_det, before);
    }
    expect_distinct_and_consistent(blocks, selection);
  }
  options.time_limit = 1e-9;
  EXPECT_EQ(selector.select(blocks, options).status, Status::deadline_reached);
  options.time_limit = 0;
  EXPECT_EQ(selector.select(blocks, options).status, Status::ok);
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

TEST(Exchange, improves_real_frames_as_the_textbook_does) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(17, [](const BlockStore& blocks) {
    const auto greedy = select_indices(blocks, with_sweeps(Strategy::greedy, 8, 0));
    EXPECT_EQ(select_indices(blocks, with_sweeps(Strategy::greedy, 8, 2)), textbook_exchange(blocks, greedy, 2));
  });
}

// One number for all families, recorded once: no compiler, instruction set or C library may change it.
TEST(Exchange, gives_the_recorded_answers) {
  sim::Hash hash;  // over the indices
  for_every_recorded(500, [&](const BlockStore& blocks) {
    for (const std::uint32_t index : select_indices(blocks, with_sweeps(Strategy::lazy_greedy, 12, 2))) hash.add(index);
  });
  EXPECT_EQ(hash.value(), 7507168773569646415U);
}

}  // namespace
}  // namespace maxlogdet::test
