// SPDX-License-Identifier: MIT
// Selectors that use blocks, against direct calls of the library.
#include "bench/world/feature_selector.hpp"

#include "tests/bench/selector_cases.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

// Calls the library directly, on a frame of these matches alone.
Indices selected_by_library(const Frame& frame, const Indices& candidates, const BlockOptions& block_options,
                            const Options& options) {
  Frame alone = frame;
  alone.matches.clear();
  for (const std::uint32_t i : candidates) alone.matches.push_back(frame.matches[i]);
  BlockStore blocks;
  build_blocks(alone, block_options, blocks);
  Indices selected;
  for (const std::uint32_t i : select_indices(blocks, options)) selected.push_back(candidates[i]);
  return selected;
}

Indices selected_by_library(const Frame& frame, const Indices& candidates, const SelectorSettings& settings) {
  Options options = settings.search;
  options.budget = settings.budget;
  return selected_by_library(frame, candidates, settings.blocks, options);
}

TEST(FeatureSelector, md_is_the_library_on_the_blocks_of_the_candidates) {
  TracedRandom random;
  for (const BlockKind& kind : block_kinds) {
    for (const Strategy strategy : {Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
      SelectorSettings settings = settings_of(SelectorKind::md, 60);
      settings.blocks.weighting = kind.weighting;
      settings.blocks.depth_cue = kind.depth_cue;
      settings.search.strategy = strategy;
      settings.search.stochastic.epsilon = 0.3;
      settings.search.stochastic.seed = random.seed();
      FeatureSelector selector(settings);
      for (const std::size_t n : {150U, 500U, 300U}) {
        const Frame frame = make_scene(sim::Scene::euroc_like, n, random.seed() + n);
        const Indices candidates = some_of(random, frame);
        EXPECT_EQ(selector.select(frame, candidates), selected_by_library(frame, candidates, settings)) << kind.name;
      }
    }
  }
}

TEST(FeatureSelector, quality_md_is_md_among_the_best_by_quality) {
  TracedRandom random;
  for (const std::size_t pool : {60U, 120U, 1000U}) {
    const Frame frame = make_scene(sim::Scene::euroc_like, 400, random.seed());
    const Indices candidates = some_of(random, frame);
    SelectorSettings settings = settings_of(SelectorKind::quality_md, 60);
    settings.pool = pool;
    EXPECT_EQ(FeatureSelector(settings).select(frame, candidates),
              selected_by_library(frame, by_quality(frame, candidates, pool), settings))
        << pool;
  }
}

// Counts indices by group.
template <class GroupOf>
std::map<std::int64_t, std::size_t> counts_of(const Indices& indices, const GroupOf& group_of) {
  std::map<std::int64_t, std::size_t> counts;
  for (const std::uint32_t i : indices) ++counts[group_of(i)];
  return counts;
}

// The definition, by incrementing.
std::size_t maximum_for(const std::map<std::int64_t, std::size_t>& sizes, std::size_t budget, double slack) {
  auto maximum =
      static_cast<std::size_t>(std::ceil(slack * static_cast<double>(budget) / static_cast<double>(sizes.size())));
  for (;; ++maximum) {
    std::size_t places = 0;
    for (const auto& [group, size] : sizes) places += std::min(size, maximum);
    if (places >= budget) return maximum;
  }
}

TEST(FeatureSelector, md_with_a_maximum_is_the_library_with_groups) {
  TracedRandom random;
  for (std::size_t trial = trials(60); trial > 0; --trial) {
    const sim::Scene scene = random.chance(0.5) ? sim::Scene::euroc_like : sim::Scene::clustered;
    const Frame frame = make_scene(scene, 300, random.seed() + trial);
    const Indices candidates = some_of(random, frame);
    SelectorSettings settings = settings_of(SelectorKind::md_cells, static_cast<std::size_t>(random.integer(1, 150)));
    settings.grid = {random.integer(1, 10), random.integer(1, 8)};
    settings.slack = random.uniform(0.1, 3);
    settings.search.strategy = strategies[random.index(std::size(strategies))];
    const auto group_of = [&](std::uint32_t i) -> std::int64_t {
      return settings.grid.cell_of(frame, frame.matches[i]);
    };
    const std::size_t maximum = maximum_for(counts_of(candidates, group_of), settings.budget, settings.slack);
    const Indices selected = FeatureSelector(settings).select(frame, candidates);
    EXPECT_EQ(selected.size(), settings.budget);
    for (const auto& [group, count] : counts_of(selected, group_of)) EXPECT_LE(count, maximum) << group;
    if (settings.search.strategy == Strategy::stochastic_greedy) continue;

    Indices groups;
    for (const std::uint32_t i : candidates) groups.push_back(static_cast<std::uint32_t>(group_of(i)));
    Options options;
    options.budget = settings.budget;
    options.groups.ids = groups.data();
    options.groups.count = 1000;
    options.groups.maximum = maximum;
    EXPECT_EQ(selected, selected_by_library(frame, candidates, settings.blocks, options));
  }
}

TEST(FeatureSelector, refuses_unusable_input) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 100, 1);
  Indices candidates(100);
  std::iota(candidates.begin(), candidates.end(), 0U);
  const SelectorSettings md = settings_of(SelectorKind::md, 10);
  SelectorSettings epsilon = md;
  epsilon.search.strategy = Strategy::stochastic_greedy;
  epsilon.search.stochastic.epsilon = 2;
  EXPECT_THROW(FeatureSelector(epsilon).select(frame, candidates), std::invalid_argument);
  Frame broken = frame;
  broken.camera.fx = 0;
  EXPECT_THROW(FeatureSelector(md).select(broken, candidates), std::invalid_argument);
}

}  // namespace
}  // namespace maxlogdet::test
