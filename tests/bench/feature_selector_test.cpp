// SPDX-License-Identifier: MIT
#include "bench/world/feature_selector.hpp"

#include "tests/bench/selector_cases.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

constexpr SelectorKind kinds[] = {SelectorKind::quality,    SelectorKind::bucket,   SelectorKind::md,
                                  SelectorKind::quality_md, SelectorKind::random,   SelectorKind::inl,
                                  SelectorKind::all,        SelectorKind::md_cells, SelectorKind::md_spread};

TEST(FeatureSelector, selects_distinct_candidates_up_to_its_budget_and_draws_from_its_seed_alone) {
  TracedRandom random;
  for (const SelectorKind kind : kinds) {
    SCOPED_TRACE(to_string(kind));
    bool differs = false;
    for (const std::size_t budget : {0U, 1U, 20U, 100U, 1000U}) {
      const Frame frame = make_scene(sim::Scene::euroc_like, 300, random.seed() + budget);
      const Indices candidates = some_of(random, frame);
      FeatureSelector selector(settings_of(kind, budget, 5)), same(settings_of(kind, budget, 5));
      const Indices selected = selector.select(frame, candidates);
      const bool all = !has_budget(kind);
      EXPECT_EQ(selected.size(), all ? candidates.size() : std::min(budget, candidates.size()));
      EXPECT_EQ(std::set<std::uint32_t>(selected.begin(), selected.end()).size(), selected.size());
      EXPECT_TRUE(std::all_of(selected.begin(), selected.end(), [&](std::uint32_t i) {
        return std::binary_search(candidates.begin(), candidates.end(), i);
      }));
      EXPECT_EQ(same.select(frame, candidates), selected);
      differs = differs || FeatureSelector(settings_of(kind, budget, 6)).select(frame, candidates) != selected;
      EXPECT_TRUE(selector.select(frame, {}).empty());
    }
    EXPECT_EQ(differs, kind == SelectorKind::random || kind == SelectorKind::bucket);
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

// Calls the library directly, on a frame of these matches alone; `groups`: of these matches, or none.
Indices selected_by_library(const Frame& frame, const Indices& candidates, const SelectorSettings& settings,
                            const Indices& groups = {}, std::size_t maximum = 0) {
  Frame alone = frame;
  alone.matches.clear();
  for (const std::uint32_t i : candidates) alone.matches.push_back(frame.matches[i]);
  BlockStore blocks;
  build_blocks(alone, settings.blocks, blocks);
  Options options = settings.search;
  options.budget = settings.budget;
  if (!groups.empty()) {
    options.groups.ids = groups.data();
    options.groups.count = 1000;
    options.groups.maximum = maximum;
  }
  Indices selected;
  for (const std::uint32_t i : select_indices(blocks, options)) selected.push_back(candidates[i]);
  return selected;
}

TEST(FeatureSelector, md_is_the_library_on_the_blocks_of_the_candidates_or_of_the_best_by_quality) {
  TracedRandom random;
  for (const BlockKind& kind : block_kinds) {
    for (const Strategy strategy : {Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
      SelectorSettings settings = settings_of(SelectorKind::md, 60);
      settings.blocks.weighting = kind.weighting;
      settings.blocks.depth_cue = kind.depth_cue;
      settings.search.strategy = strategy;
      settings.search.stochastic.seed = random.seed();
      FeatureSelector selector(settings);
      settings.kind = SelectorKind::quality_md;
      settings.pool = 120;
      for (const std::size_t n : {250U, 500U, 300U}) {
        const Frame frame = make_scene(sim::Scene::euroc_like, n, random.seed() + n);
        const Indices candidates = some_of(random, frame);
        EXPECT_EQ(selector.select(frame, candidates), selected_by_library(frame, candidates, settings)) << kind.name;
        if (strategy == Strategy::stochastic_greedy) continue;  // it draws by places in the store
        EXPECT_EQ(FeatureSelector(settings).select(frame, candidates),
                  selected_by_library(frame, by_quality(frame, candidates, 120), settings));
      }
    }
  }
}

TEST(FeatureSelector, md_cells_is_the_library_with_the_smallest_maximum_that_fills_the_budget) {
  TracedRandom random;
  for (std::size_t trial = trials(60); trial > 0; --trial) {
    const sim::Scene scene = random.chance(0.5) ? sim::Scene::euroc_like : sim::Scene::clustered;
    const Frame frame = make_scene(scene, 300, random.seed() + trial);
    const Indices candidates = some_of(random, frame);
    SelectorSettings settings = settings_of(SelectorKind::md_cells, static_cast<std::size_t>(random.integer(1, 150)));
    settings.grid = {random.integer(1, 10), random.integer(1, 8)};
    settings.slack = random.uniform(0.1, 3);
    Indices cells;
    std::map<std::uint32_t, std::size_t> sizes;
    for (const std::uint32_t i : candidates) {
      cells.push_back(settings.grid.cell_of(frame, frame.matches[i]));
      ++sizes[cells.back()];
    }
    const double share = static_cast<double>(settings.budget) / static_cast<double>(sizes.size());
    auto maximum = static_cast<std::size_t>(std::ceil(settings.slack * share));
    const auto places = [&] {
      std::size_t sum = 0;
      for (const auto& [cell, size] : sizes) sum += std::min(size, maximum);
      return sum;
    };
    while (places() < settings.budget) ++maximum;
    EXPECT_EQ(FeatureSelector(settings).select(frame, candidates),
              selected_by_library(frame, candidates, settings, cells, maximum));
  }
}

TEST(FeatureSelector, refuses_unusable_input) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 100, 1);
  Indices candidates(100);
  std::iota(candidates.begin(), candidates.end(), 0U);
  SelectorSettings epsilon = settings_of(SelectorKind::md, 10);
  epsilon.search.strategy = Strategy::stochastic_greedy;
  epsilon.search.stochastic.epsilon = 2;
  EXPECT_THROW(FeatureSelector(epsilon).select(frame, candidates), std::invalid_argument);
  Frame broken = frame;
  broken.camera.fx = 0;
  EXPECT_THROW(FeatureSelector(settings_of(SelectorKind::md, 10)).select(broken, candidates), std::invalid_argument);
}

}  // namespace
}  // namespace maxlogdet::test
