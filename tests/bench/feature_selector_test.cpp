// SPDX-License-Identifier: MIT
// Properties of all selectors; selectors of blocks, against direct calls of the library.
#include "bench/world/feature_selector.hpp"

#include "tests/bench/selector_cases.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

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

// Counts indices by group.
template <class GroupOf>
std::map<std::int64_t, std::size_t> counts_of(const Indices& indices, const GroupOf& group_of) {
  std::map<std::int64_t, std::size_t> counts;
  for (const std::uint32_t i : indices) ++counts[group_of(i)];
  return counts;
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
    const auto cell_of = [&](std::uint32_t i) -> std::int64_t {
      return settings.grid.cell_of(frame, frame.matches[i]);
    };
    auto taken = counts_of(FeatureSelector(settings).select(frame, candidates), cell_of);
    std::size_t largest = 0;
    for (const auto& [cell, count] : taken) largest = std::max(largest, count);
    for (const auto& [cell, count] : counts_of(candidates, cell_of)) {
      if (taken[cell] < count) {
        EXPECT_GE(taken[cell] + 1, largest) << "cell " << cell;
      }
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
