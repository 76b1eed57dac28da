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

Frame with_keyframes(Frame frame, int keyframes) {
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    frame.matches[i].keyframe = static_cast<std::int64_t>(i * i) % keyframes;
  }
  return frame;
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

// With groups these answer as lazy greedy does, which also replaces those that take no groups.
bool is_replaced_or_exact(Strategy strategy) {
  return strategy == Strategy::greedy || strategy == Strategy::lazy_greedy || strategy == Strategy::automatic ||
         !supports_groups_and_targets(strategy);
}

TEST(FeatureSelector, md_with_a_maximum_is_the_library_with_groups) {
  TracedRandom random;
  for (std::size_t trial = trials(60); trial > 0; --trial) {
    const sim::Scene scene = random.chance(0.5) ? sim::Scene::euroc_like : sim::Scene::clustered;
    const Frame frame = with_keyframes(make_scene(scene, 300, random.seed() + trial), random.integer(1, 20));
    const Indices candidates = some_of(random, frame);
    for (const SelectorKind kind : {SelectorKind::md_cells, SelectorKind::md_keyframes}) {
      SelectorSettings settings = settings_of(kind, static_cast<std::size_t>(random.integer(1, 150)));
      settings.grid = {random.integer(1, 10), random.integer(1, 8)};
      settings.slack = random.uniform(0.1, 3);
      settings.search.strategy = strategies[random.index(std::size(strategies))];
      const auto group_of = [&](std::uint32_t i) -> std::int64_t {
        if (kind == SelectorKind::md_keyframes) return frame.matches[i].keyframe;
        return settings.grid.cell_of(frame, frame.matches[i]);
      };
      const std::size_t maximum = maximum_for(counts_of(candidates, group_of), settings.budget, settings.slack);
      const Indices selected = FeatureSelector(settings).select(frame, candidates);
      EXPECT_EQ(selected.size(), settings.budget);
      for (const auto& [group, count] : counts_of(selected, group_of)) EXPECT_LE(count, maximum) << group;
      if (!is_replaced_or_exact(settings.search.strategy)) continue;

      Indices groups;
      for (const std::uint32_t i : candidates) groups.push_back(static_cast<std::uint32_t>(group_of(i)));
      Options options;
      options.budget = settings.budget;
      options.groups.ids = groups.data();
      options.groups.count = 1000;
      options.groups.maximum = maximum;
      const Indices expected = selected_by_library(frame, candidates, settings.blocks, options);
      EXPECT_EQ(selected, expected) << to_string(kind);
    }
  }
}

TEST(FeatureSelector, points_of_unknown_keyframes_share_no_group) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 200, 5);
  Indices candidates(200);
  std::iota(candidates.begin(), candidates.end(), 0U);
  const Indices md = FeatureSelector(settings_of(SelectorKind::md, 50)).select(frame, candidates);
  EXPECT_EQ(FeatureSelector(settings_of(SelectorKind::md_keyframes, 50)).select(frame, candidates), md);
}

TEST(FeatureSelector, half_random_is_md_and_then_uniform) {
  TracedRandom random;
  const Frame frame = make_scene(sim::Scene::euroc_like, 60, random.seed());
  const Indices candidates = some_of(random, frame);
  FeatureSelector selector(settings_of(SelectorKind::half_random, 11));
  const Indices md = FeatureSelector(settings_of(SelectorKind::md, 6)).select(frame, candidates);
  std::map<std::uint32_t, int> drawn;
  const std::size_t runs = trials(4000);
  for (std::size_t run = 0; run < runs; ++run) {
    const Indices selected = selector.select(frame, candidates);
    ASSERT_EQ(selected.size(), 11U);
    ASSERT_TRUE(std::equal(md.begin(), md.end(), selected.begin()));
    for (std::size_t s = 6; s < 11; ++s) ++drawn[selected[s]];
  }
  const double probability = 5 / static_cast<double>(candidates.size() - 6),
               mean = static_cast<double>(runs) * probability;
  for (const std::uint32_t i : candidates) {
    const double expected = std::count(md.begin(), md.end(), i) > 0 ? 0 : mean;
    EXPECT_NEAR(drawn[i], expected, 5 * std::sqrt(mean)) << i;
  }
}

TEST(FeatureSelector, leverage_draws_by_the_share_of_information) {
  TracedRandom random;
  const Frame frame = make_scene(sim::Scene::euroc_like, 40, random.seed());
  const Indices candidates = some_of(random, frame);
  BlockStore blocks;
  build_blocks(frame, BlockOptions(), blocks);
  Matrix6 information = 1e-5 * Matrix6::Identity();
  for (const std::uint32_t i : candidates) information += gram(stored_block(blocks, i));
  std::vector<double> leverages;
  double sum = 0;
  for (const std::uint32_t i : candidates) {
    leverages.push_back(product(inverse(information), gram(stored_block(blocks, i))).trace());
    sum += leverages.back();
  }
  EXPECT_NEAR(sum, 6, 1e-3) << "except for the prior";
  // The first of one, and the second given the first.
  FeatureSelector selector(settings_of(SelectorKind::leverage, 2));
  std::map<std::uint32_t, double> first, second;
  const auto runs = static_cast<double>(trials(20000));
  for (std::size_t run = trials(20000); run > 0; --run) {
    const Indices selected = selector.select(frame, candidates);
    ASSERT_EQ(selected.size(), 2U);
    ++first[selected[0]];
    ++second[selected[1]];
  }
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const double p = leverages[c] / sum;
    EXPECT_NEAR(first[candidates[c]], runs * p, 5 * std::sqrt(runs * p) + 1);
    double q = 0;
    for (std::size_t other = 0; other < candidates.size(); ++other) {
      if (other != c) q += leverages[other] / sum * leverages[c] / (sum - leverages[other]);
    }
    EXPECT_NEAR(second[candidates[c]], runs * q, 5 * std::sqrt(runs * q) + 1);
  }
}

TEST(FeatureSelector, shared_errors_are_those_of_cells_and_of_keyframes) {
  TracedRandom random;
  for (std::size_t trial = trials(10); trial > 0; --trial) {
    Frame frame = with_keyframes(make_scene(sim::Scene::euroc_like, 150, random.seed() + trial), 7);
    frame.matches[3].keyframe = -1;
    const Indices candidates = some_of(random, frame);
    for (const SelectorKind kind : {SelectorKind::shared_cells, SelectorKind::shared_keyframes}) {
      SelectorSettings settings = settings_of(kind, 30);
      settings.grid = {4, 3};
      settings.tau = random.uniform(0.1, 2);
      Indices groups;
      for (const sim::Match& match : frame.matches) {
        groups.push_back(kind == SelectorKind::shared_cells ? settings.grid.cell_of(frame, match)
                                                            : static_cast<std::uint32_t>(match.keyframe + 1));
      }
      std::vector<sim::WhitenedMatch> matches(frame.matches.size());
      for (const std::uint32_t i : candidates) matches[i] = whiten(frame, i, settings.blocks, nullptr);
      Indices expected;
      sim::SharedErrorSelection().select(matches, groups, 12, settings.tau, 1e-5 * Matrix6::Identity(), 30, expected);
      EXPECT_EQ(FeatureSelector(settings).select(frame, candidates), expected) << to_string(kind);
    }
  }
}

TEST(FeatureSelector, refuses_unusable_input) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 100, 1);
  Indices candidates(100);
  std::iota(candidates.begin(), candidates.end(), 0U);
  const SelectorSettings md = settings_of(SelectorKind::md, 10), shared = settings_of(SelectorKind::shared_cells, 10);
  EXPECT_EQ(FeatureSelector(shared).select(frame, candidates).size(), 10U);
  SelectorSettings epsilon = md, bias = shared, depth = shared, tau = shared;
  epsilon.search.strategy = Strategy::stochastic_greedy;
  epsilon.search.stochastic.epsilon = 2;
  bias.blocks.weighting = Weighting::map_bias;
  depth.blocks.depth_cue = DepthCue::depth;
  tau.tau = -1;
  for (const SelectorSettings& bad : {epsilon, bias, depth, tau}) {
    EXPECT_THROW(FeatureSelector(bad).select(frame, candidates), std::invalid_argument);
  }
  Frame broken = frame;
  broken.camera.fx = 0;
  EXPECT_THROW(FeatureSelector(md).select(broken, candidates), std::invalid_argument);
}

}  // namespace
}  // namespace maxlogdet::test
