// SPDX-License-Identifier: MIT
// Properties of all selectors; selectors of blocks, against direct calls of the library.
#include "bench/world/feature_selector.hpp"

#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

using sim::FeatureSelector;
using sim::Frame;
using sim::SelectorKind;
using sim::SelectorSettings;
using Indices = std::vector<std::uint32_t>;

SelectorSettings settings_of(SelectorKind kind, std::size_t budget, std::uint64_t seed = 0) {
  SelectorSettings settings;
  settings.kind = kind;
  settings.budget = budget;
  settings.seed = seed;
  return settings;
}

// About three of four matches.
Indices some_of(Random& random, const Frame& frame) {
  Indices some;
  for (std::uint32_t i = 0; i < frame.matches.size(); ++i) {
    if (random.chance(0.75)) some.push_back(i);
  }
  return some;
}

TEST(FeatureSelector, selects_distinct_candidates_up_to_its_budget_and_draws_from_its_seed_alone) {
  TracedRandom random;
  for (const SelectorKind kind : sim::selector_kinds) {
    if (kind == SelectorKind::observability) continue;  // needs earlier poses
    SCOPED_TRACE(to_string(kind));
    for (const std::size_t budget : {0U, 1U, 30U, 100U, 1000U}) {
      const Frame frame = make_scene(sim::Scene::euroc_like, 300, random.seed() + budget);
      const Indices candidates = some_of(random, frame);
      FeatureSelector selector(settings_of(kind, budget, 5));
      const Indices selected = selector.select(frame, candidates);
      Indices sorted = selected;
      std::sort(sorted.begin(), sorted.end());
      EXPECT_EQ(sorted.size(), has_budget(kind) ? std::min(budget, candidates.size()) : candidates.size());
      EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end());
      EXPECT_TRUE(std::includes(candidates.begin(), candidates.end(), sorted.begin(), sorted.end()));
      EXPECT_TRUE(selector.select(frame, {}).empty());
      EXPECT_EQ(FeatureSelector(settings_of(kind, budget, 5)).select(frame, candidates), selected);
      if (budget != 30 && budget != 100) continue;  // one match, or all, may be the same by chance
      const bool draws = kind == SelectorKind::random || kind == SelectorKind::bucket;
      EXPECT_EQ(FeatureSelector(settings_of(kind, budget, 6)).select(frame, candidates) != selected, draws);
    }
  }
}

TEST(FeatureSelector, bucket_spreads_over_cells) {
  TracedRandom random;
  for (std::size_t trial = trials(100); trial > 0; --trial) {
    const sim::Scene scene = random.chance(0.5) ? sim::Scene::euroc_like : sim::Scene::clustered;
    const Frame frame = make_scene(scene, 400, random.seed() + trial);
    const Indices candidates = some_of(random, frame);
    SelectorSettings settings = settings_of(SelectorKind::bucket, 1 + random.index(200), trial);
    settings.grid = {random.integer(1, 12), random.integer(1, 9)};
    std::map<std::uint32_t, std::size_t> all, taken;  // by cell
    for (const std::uint32_t i : candidates) ++all[settings.grid.cell_of(frame, frame.matches[i])];
    for (const std::uint32_t i : FeatureSelector(settings).select(frame, candidates)) {
      ++taken[settings.grid.cell_of(frame, frame.matches[i])];
    }
    std::size_t largest = 0;
    for (const auto& [cell, count] : taken) largest = std::max(largest, count);
    for (const auto& [cell, count] : all) {
      EXPECT_TRUE(taken[cell] == count || taken[cell] + 1 >= largest) << "cell " << cell;
    }
  }
}

// Random, and bucket: with a single cell it is as uniform, and of several cells it prefers none.
TEST(FeatureSelector, random_and_bucket_select_uniformly) {
  Frame frame = make_scene(sim::Scene::euroc_like, 40, 3);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    frame.matches[i].u = i % 4 < 2 ? 10 : 700;
    frame.matches[i].v = i % 2 == 0 ? 10 : 400;
  }
  Indices candidates(20);
  std::iota(candidates.begin(), candidates.end(), 10U);
  const struct {
    SelectorKind kind;
    sim::ImageGrid grid;
    std::size_t budget;
  } cases[] = {{SelectorKind::random, {1, 1}, 5}, {SelectorKind::bucket, {1, 1}, 5}, {SelectorKind::bucket, {2, 2}, 2}};
  for (const auto& [kind, grid, budget] : cases) {
    SCOPED_TRACE(std::string(to_string(kind)) + " " + std::to_string(grid.cells()));
    SelectorSettings settings = settings_of(kind, budget);
    settings.grid = grid;
    FeatureSelector selector(settings);
    std::vector<int> counts(40, 0);
    const auto runs = static_cast<double>(trials(10000));
    for (std::size_t run = trials(10000); run > 0; --run) {
      for (const std::uint32_t i : selector.select(frame, candidates)) ++counts[i];
    }
    const double share = static_cast<double>(budget) / static_cast<double>(candidates.size());
    for (const std::uint32_t i : candidates) {
      EXPECT_NEAR(counts[i], runs * share, 5 * std::sqrt(runs * share * (1 - share)));
    }
  }
}

Indices best_by_quality(const Frame& frame, Indices candidates, std::size_t count) {
  std::stable_sort(candidates.begin(), candidates.end(), [&](std::uint32_t a, std::uint32_t b) {
    return frame.matches[a].desc_dist < frame.matches[b].desc_dist;
  });
  candidates.resize(std::min(count, candidates.size()));
  return candidates;
}

// The library, on a frame of these matches alone.
Indices selected_by_library(const Frame& frame, const Indices& candidates, const SelectorSettings& settings) {
  Frame alone = frame;
  alone.matches.clear();
  for (const std::uint32_t i : candidates) alone.matches.push_back(frame.matches[i]);
  BlockStore blocks;
  build_blocks(alone, settings.blocks, blocks);
  Options options = settings.search;
  options.budget = settings.budget;
  Indices selected;
  for (const std::uint32_t i : select_indices(blocks, options)) selected.push_back(candidates[i]);
  return selected;
}

TEST(FeatureSelector, quality_md_is_the_library_among_the_best_by_quality_and_md_among_all_candidates) {
  TracedRandom random;
  for (const BlockKind& kind : block_kinds) {
    for (const Strategy strategy : {Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
      SelectorSettings settings = settings_of(SelectorKind::md, 60);
      settings.blocks.weighting = kind.weighting;
      settings.blocks.depth_cue = kind.depth_cue;
      settings.search.strategy = strategy;
      settings.search.stochastic.epsilon = 0.3;
      settings.search.stochastic.seed = random.seed();
      SelectorSettings of_pool = settings;
      of_pool.kind = SelectorKind::quality_md;
      of_pool.pool = 90;
      FeatureSelector md(settings), quality_md(of_pool);
      for (const std::size_t n : {150U, 500U, 300U}) {
        Frame frame = make_scene(sim::Scene::euroc_like, n, random.seed() + n);
        for (sim::Match& match : frame.matches) match.desc_dist = random.integer(0, 12);
        const Indices candidates = some_of(random, frame);
        EXPECT_EQ(md.select(frame, candidates), selected_by_library(frame, candidates, settings)) << kind.name;
        EXPECT_EQ(quality_md.select(frame, candidates),
                  selected_by_library(frame, best_by_quality(frame, candidates, 90), settings));
        EXPECT_EQ(FeatureSelector(settings_of(SelectorKind::quality, 40)).select(frame, candidates),
                  best_by_quality(frame, candidates, 40));
      }
    }
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
