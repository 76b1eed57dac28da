// SPDX-License-Identifier: MIT
#include "bench/world/feature_selector.hpp"

#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

using Indices = std::vector<std::uint32_t>;
using sim::FeatureSelector;
using sim::Frame;
using sim::SelectorKind;
using sim::SelectorSettings;

SelectorSettings settings_of(SelectorKind kind, std::size_t budget, std::uint64_t seed = 1) {
  SelectorSettings settings;
  settings.kind = kind;
  settings.budget = budget;
  settings.seed = seed;
  return settings;
}

Indices some_of(Random& random, const Frame& frame, double share = 0.7) {
  Indices candidates;
  for (std::uint32_t i = 0; i < frame.matches.size(); ++i) {
    if (random.chance(share)) candidates.push_back(i);
  }
  return candidates;
}

Indices sorted(Indices indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}

// The definition: sort all by (distance, index).
Indices by_quality(const Frame& frame, const Indices& candidates, std::size_t count) {
  std::set<std::pair<double, std::uint32_t>> order;
  for (const std::uint32_t i : candidates) order.insert({frame.matches[i].desc_dist, i});
  Indices best;
  for (const auto& [distance, i] : order) {
    if (best.size() < count) best.push_back(i);
  }
  return best;
}

TEST(FeatureSelector, selects_distinct_candidates_up_to_its_budget) {
  TracedRandom random;
  for (const SelectorKind kind : sim::selector_kinds) {
    if (kind == SelectorKind::observability) continue;  // needs earlier poses
    SCOPED_TRACE(to_string(kind));
    for (const std::size_t budget : {0U, 1U, 20U, 100U, 1000U}) {
      const Frame frame = make_scene(sim::Scene::euroc_like, 300, random.seed() + budget);
      const Indices candidates = some_of(random, frame);
      FeatureSelector selector(settings_of(kind, budget));
      const Indices selected = sorted(selector.select(frame, candidates));
      const bool all = !has_budget(kind);
      EXPECT_EQ(selected.size(), all ? candidates.size() : std::min(budget, candidates.size()));
      EXPECT_EQ(std::adjacent_find(selected.begin(), selected.end()), selected.end());
      EXPECT_TRUE(std::includes(candidates.begin(), candidates.end(), selected.begin(), selected.end()));
      EXPECT_TRUE(selector.select(frame, {}).empty());
    }
  }
}

TEST(FeatureSelector, draws_from_its_seed_alone) {
  TracedRandom random;
  for (const SelectorKind kind : sim::selector_kinds) {
    if (kind == SelectorKind::observability) continue;  // needs earlier poses
    FeatureSelector one(settings_of(kind, 30, 5)), same(settings_of(kind, 30, 5)), other(settings_of(kind, 30, 6));
    bool differs = false;
    for (std::uint64_t i = 0; i < 3; ++i) {
      const Frame frame = make_scene(sim::Scene::euroc_like, 200, random.seed() + i);
      const Indices candidates = some_of(random, frame);
      const Indices selected = one.select(frame, candidates);
      EXPECT_EQ(same.select(frame, candidates), selected) << to_string(kind);
      differs = differs || other.select(frame, candidates) != selected;
    }
    const bool draws = kind == SelectorKind::random || kind == SelectorKind::bucket;
    EXPECT_EQ(differs, draws) << to_string(kind);
  }
}

TEST(FeatureSelector, quality_takes_the_lowest_distances_and_of_equal_ones_the_lowest_index) {
  TracedRandom random;
  for (std::size_t trial = trials(50); trial > 0; --trial) {
    Frame frame = make_scene(sim::Scene::euroc_like, 150, random.seed());
    for (sim::Match& match : frame.matches) match.desc_dist = random.integer(0, 12);
    Indices candidates = some_of(random, frame);
    std::reverse(candidates.begin(), candidates.end());
    EXPECT_EQ(FeatureSelector(settings_of(SelectorKind::quality, 40)).select(frame, candidates),
              by_quality(frame, candidates, 40));
  }
}

TEST(FeatureSelector, bucket_spreads_over_cells) {
  TracedRandom random;
  for (std::size_t trial = trials(100); trial > 0; --trial) {
    const sim::Scene scene = random.chance(0.5) ? sim::Scene::euroc_like : sim::Scene::clustered;
    const Frame frame = make_scene(scene, 400, random.seed() + trial);
    const Indices candidates = some_of(random, frame);
    SelectorSettings settings = settings_of(SelectorKind::bucket, static_cast<std::size_t>(random.integer(1, 200)));
    settings.grid = {random.integer(1, 12), random.integer(1, 9)};
    settings.seed = trial;
    std::map<std::uint32_t, int> there, taken;
    for (const std::uint32_t i : candidates) ++there[settings.grid.cell_of(frame, frame.matches[i])];
    for (const std::uint32_t i : FeatureSelector(settings).select(frame, candidates)) {
      ++taken[settings.grid.cell_of(frame, frame.matches[i])];
    }
    int largest = 0;
    for (const auto& [cell, count] : taken) largest = std::max(largest, count);
    for (const auto& [cell, count] : there) {
      if (taken[cell] < count) {
        EXPECT_GE(taken[cell], largest - 1) << "cell " << cell;
      }
    }
  }
}

TEST(FeatureSelector, bucket_prefers_no_cell) {
  Frame frame = make_scene(sim::Scene::euroc_like, 24, 3);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    frame.matches[i].u = i < 12 ? 10 : 700;
    frame.matches[i].v = i % 2 == 0 ? 10 : 400;
  }
  Indices candidates(24);
  std::iota(candidates.begin(), candidates.end(), 0U);
  SelectorSettings settings = settings_of(SelectorKind::bucket, 2);
  settings.grid = {2, 2};
  FeatureSelector selector(settings);
  std::vector<int> counts(4, 0);
  const auto runs = static_cast<double>(trials(4000));
  for (std::size_t run = trials(4000); run > 0; --run) {
    for (const std::uint32_t i : selector.select(frame, candidates)) {
      ++counts[settings.grid.cell_of(frame, frame.matches[i])];
    }
  }
  for (const int count : counts) EXPECT_NEAR(count, runs / 2, 5 * std::sqrt(runs) / 2);
}

// Bucket with a single cell is as uniform as random.
TEST(FeatureSelector, random_and_bucket_select_uniformly) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 40, 3);
  Indices candidates(20);
  std::iota(candidates.begin(), candidates.end(), 10U);
  for (const SelectorKind kind : {SelectorKind::random, SelectorKind::bucket}) {
    SelectorSettings settings = settings_of(kind, 5);
    settings.grid = {1, 1};
    FeatureSelector selector(settings);
    std::vector<int> counts(40, 0);
    const auto runs = static_cast<double>(trials(10000));
    for (std::size_t run = trials(10000); run > 0; --run) {
      for (const std::uint32_t i : selector.select(frame, candidates)) ++counts[i];
    }
    for (const std::uint32_t i : candidates) {
      EXPECT_NEAR(counts[i], runs / 4, 5 * std::sqrt(runs * 3 / 16)) << to_string(kind);
    }
  }
}

// Calls the library directly, on a frame of these matches alone.
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
