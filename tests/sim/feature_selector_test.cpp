// SPDX-License-Identifier: MIT
#include "sim/feature_selector.hpp"
#include "tests/support/allocation_counter.hpp"

#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

using Indices = std::vector<std::uint32_t>;
using sim::FeatureSelector;
using sim::Frame;
using sim::Matrix12;
using sim::ObservabilitySelection;
using sim::Pose;
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

// Small steps about where the frame is, the last of them first.
std::vector<Pose> poses_before(Random& random, const Frame& frame, int count) {
  std::vector<Pose> poses;
  Pose T = sim::pose_of(frame.T_cw_prior);
  for (int i = 0; i < count; ++i) {
    Vector6 v;
    for (double& entry : v) entry = random.uniform(-0.05, 0.05);
    T = sim::exp_se3(v) * T;
    poses.push_back(T);
  }
  return poses;
}

TEST(FeatureSelector, selects_distinct_candidates_and_as_many_as_asked_for) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const SelectorKind kind : sim::selector_kinds) {
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

TEST(FeatureSelector, budgets_and_rejection_are_those_of_its_kinds) {
  using K = SelectorKind;
  std::size_t with_budget = 0;
  for (const K kind : sim::selector_kinds) {
    if (kind == K::inl || kind == K::all || kind == K::all_weighted) continue;
    EXPECT_TRUE(has_budget(kind) && rejects_outliers(kind)) << to_string(kind);
    ++with_budget;
  }
  EXPECT_EQ(with_budget, 12U);
  EXPECT_TRUE(!has_budget(K::inl) && rejects_outliers(K::inl));
  for (const K kind : {K::all, K::all_weighted}) EXPECT_TRUE(!has_budget(kind) && !rejects_outliers(kind));
}

TEST(FeatureSelector, draws_from_its_seed_alone) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const SelectorKind kind : sim::selector_kinds) {
    FeatureSelector one(settings_of(kind, 30, 5)), same(settings_of(kind, 30, 5)), other(settings_of(kind, 30, 6));
    bool differs = false;
    for (std::uint64_t i = 0; i < 3; ++i) {
      const Frame frame = make_scene(sim::Scene::euroc_like, 200, random.seed() + i);
      const Indices candidates = some_of(random, frame);
      const Indices selected = one.select(frame, candidates);
      EXPECT_EQ(same.select(frame, candidates), selected) << to_string(kind);
      differs = differs || other.select(frame, candidates) != selected;
    }
    const bool draws = kind == SelectorKind::random || kind == SelectorKind::bucket ||
                       kind == SelectorKind::observability || kind == SelectorKind::leverage ||
                       kind == SelectorKind::half_random;
    EXPECT_EQ(differs, draws) << to_string(kind);
  }
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

TEST(FeatureSelector, quality_takes_the_lowest_distances_and_of_equal_ones_the_lowest_index) {
  Random random;
  SCOPED_TRACE(random.name());
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
  Random random;
  SCOPED_TRACE(random.name());
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
    int most = 0;
    for (const auto& [cell, count] : taken) most = std::max(most, count);
    for (const auto& [cell, count] : there) {
      if (taken[cell] < count) {
        EXPECT_GE(taken[cell], most - 1) << "cell " << cell;
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

// Bucket with a single cell has to be as random as random.
TEST(FeatureSelector, random_and_bucket_take_every_candidate_as_often) {
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

// A frame of these matches alone, and the library called by hand.
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
  Random random;
  SCOPED_TRACE(random.name());
  for (const BlockKind& kind : block_kinds) {
    for (const Strategy strategy : {Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
      SelectorSettings settings = settings_of(SelectorKind::md, 60);
      settings.blocks.weighting = kind.weighting;
      settings.blocks.third = kind.third;
      settings.search.strategy = strategy;
      settings.search.epsilon = 0.3;
      settings.search.seed = random.seed();
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
  Random random;
  SCOPED_TRACE(random.name());
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

// How many of these are in each group.
template <class GroupOf>
std::map<std::int64_t, std::size_t> counts_of(const Indices& indices, const GroupOf& group_of) {
  std::map<std::int64_t, std::size_t> counts;
  for (const std::uint32_t i : indices) ++counts[group_of(i)];
  return counts;
}

// The definition, by counting up.
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
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(60); trial > 0; --trial) {
    const sim::Scene scene = random.chance(0.5) ? sim::Scene::euroc_like : sim::Scene::clustered;
    const Frame frame = with_keyframes(make_scene(scene, 300, random.seed() + trial), random.integer(1, 20));
    const Indices candidates = some_of(random, frame);
    for (const SelectorKind kind : {SelectorKind::md_cells, SelectorKind::md_keyframes}) {
      SelectorSettings settings = settings_of(kind, static_cast<std::size_t>(random.integer(1, 150)));
      settings.grid = {random.integer(1, 10), random.integer(1, 8)};
      settings.slack = random.uniform(0.1, 3);
      settings.search.strategy = strategies[random.integer(0, 5)];
      const auto group_of = [&](std::uint32_t i) -> std::int64_t {
        if (kind == SelectorKind::md_keyframes) return frame.matches[i].keyframe;
        return settings.grid.cell_of(frame, frame.matches[i]);
      };
      const std::size_t maximum = maximum_for(counts_of(candidates, group_of), settings.budget, settings.slack);
      const Indices selected = FeatureSelector(settings).select(frame, candidates);
      EXPECT_EQ(selected.size(), settings.budget);
      for (const auto& [group, count] : counts_of(selected, group_of)) EXPECT_LE(count, maximum) << group;
      if (settings.search.strategy == Strategy::stochastic_greedy) continue;

      Frame alone = frame;
      alone.matches.clear();
      Indices groups;
      for (const std::uint32_t i : candidates) {
        alone.matches.push_back(frame.matches[i]);
        groups.push_back(static_cast<std::uint32_t>(group_of(i)));
      }
      BlockStore blocks;
      build_blocks(alone, settings.blocks, blocks);
      Options options;
      options.budget = settings.budget;
      options.groups = groups.data();
      options.group_count = 1000;
      options.max_per_group = maximum;
      Indices expected;
      for (const std::uint32_t i : select_indices(blocks, options)) expected.push_back(candidates[i]);
      EXPECT_EQ(selected, expected) << to_string(kind);
    }
  }
}

TEST(FeatureSelector, points_of_unknown_keyframes_are_no_group) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 200, 5);
  Indices candidates(200);
  std::iota(candidates.begin(), candidates.end(), 0U);
  const Indices md = FeatureSelector(settings_of(SelectorKind::md, 50)).select(frame, candidates);
  EXPECT_EQ(FeatureSelector(settings_of(SelectorKind::md_keyframes, 50)).select(frame, candidates), md);
}

TEST(FeatureSelector, half_random_is_md_and_then_any_other) {
  Random random;
  SCOPED_TRACE(random.name());
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
  Random random;
  SCOPED_TRACE(random.name());
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
  EXPECT_NEAR(sum, 6, 1e-3) << "but for the prior";
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
  Random random;
  SCOPED_TRACE(random.name());
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

TEST(FeatureSelector, shared_errors_are_compared_with_pixel_noise_alone) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 100, 1);
  Indices candidates(100);
  std::iota(candidates.begin(), candidates.end(), 0U);
  SelectorSettings good = settings_of(SelectorKind::shared_cells, 10);
  EXPECT_EQ(FeatureSelector(good).select(frame, candidates).size(), 10U);
  SelectorSettings bias = good, depth = good, tau = good;
  bias.blocks.weighting = Weighting::map_bias;
  depth.blocks.third = ThirdMeasurement::depth;
  tau.tau = -1;
  for (const SelectorSettings& bad : {bias, depth, tau}) {
    EXPECT_THROW(FeatureSelector(bad).select(frame, candidates), std::invalid_argument);
  }
}

TEST(FeatureSelector, allocates_nothing_once_there_has_been_a_frame_as_large) {
  const Frame frame = make_scene(sim::Scene::euroc_like, 500, 1);
  const sim::MatchArrays arrays(frame);
  Indices candidates(450), selected;
  std::iota(candidates.begin(), candidates.end(), 20U);
  for (const SelectorKind kind : sim::selector_kinds) {
    if (kind == SelectorKind::observability) continue;
    SelectorSettings settings = settings_of(kind, 60);
    settings.search.threads = settings.blocks.threads = 1;
    FeatureSelector selector(settings);
    selector.select(frame, arrays.view(), candidates, selected);
    const long before = sim::allocations();
    selector.select(frame, arrays.view(), candidates, selected);
    EXPECT_EQ(sim::allocations(), before) << to_string(kind);
    EXPECT_EQ(selected.size(), has_budget(kind) ? 60 : candidates.size());
  }
}

TEST(FeatureSelector, md_says_what_it_cannot_use) {
  Frame frame = make_scene(sim::Scene::euroc_like, 100, 1);
  Indices candidates(100);
  std::iota(candidates.begin(), candidates.end(), 0U);
  SelectorSettings settings = settings_of(SelectorKind::md, 10);
  settings.search.strategy = Strategy::stochastic_greedy;
  settings.search.epsilon = 2;
  EXPECT_THROW(FeatureSelector(settings).select(frame, candidates), std::invalid_argument);
  frame.camera.fx = 0;
  EXPECT_THROW(FeatureSelector(settings_of(SelectorKind::md, 10)).select(frame, candidates), std::invalid_argument);
}

using Rows12 = Eigen::Matrix<double, Eigen::Dynamic, 12>;
constexpr double step = 1e-6;

Eigen::Vector2d project(const Frame& frame, const Pose& T_cw, const sim::Match& match) {
  const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
  return {frame.camera.fx * p.x() / p.z() + frame.camera.cx, frame.camera.fy * p.y() / p.z() + frame.camera.cy};
}

Eigen::Matrix<double, 2, 6> derivative_of_projection(const Frame& frame, const Pose& T_cw, const sim::Match& match) {
  Eigen::Matrix<double, 2, 6> H;
  for (int j = 0; j < 6; ++j) {
    const Vector6 xi = step * Vector6::Unit(j);
    H.col(j) =
        (project(frame, sim::exp_se3(xi) * T_cw, match) - project(frame, sim::exp_se3(-xi) * T_cw, match)) / (2 * step);
  }
  return H;
}

// Where an error of pose and velocity leads in one step of T <- exp(v^) T, differentiated numerically.
Matrix12 derivative_of_motion(const Vector6& v) {
  const auto error_after = [&](const Vector6& pose, const Vector6& velocity) {
    return sim::log_se3(sim::exp_se3(v + velocity) * sim::exp_se3(pose) * sim::exp_se3(-v));
  };
  Matrix12 F = Matrix12::Identity();
  for (int j = 0; j < 6; ++j) {
    const Vector6 xi = step * Vector6::Unit(j), none = Vector6::Zero();
    F.block<6, 1>(0, j) = (error_after(xi, none) - error_after(-xi, none)) / (2 * step);
    F.block<6, 1>(0, 6 + j) = (error_after(none, xi) - error_after(none, -xi)) / (2 * step);
  }
  return F;
}

// [H; H F] of every segment: the first ends at the frame's pose, the next where that one began.
std::vector<Rows12> observability_rows(const Frame& frame, const Indices& candidates, const std::vector<Pose>& before) {
  std::vector<Rows12> rows(candidates.size(), Rows12(0, 12));
  Pose end = sim::pose_of(frame.T_cw_prior);
  for (std::size_t segment = 0; segment < std::max<std::size_t>(1, before.size()); ++segment) {
    const Pose begin = before.empty() ? end : before[segment];
    const Matrix12 F = derivative_of_motion(sim::log_se3(end * begin.inverse()));
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      Eigen::Matrix<double, 2, 12> H = Eigen::Matrix<double, 2, 12>::Zero();
      H.leftCols<6>() = derivative_of_projection(frame, end, frame.matches[candidates[c]]);
      rows[c].conservativeResize(rows[c].rows() + 4, 12);
      rows[c].bottomRows<4>() << H, H * F;
    }
    end = begin;
  }
  return rows;
}

double smallest_singular_value(const Rows12& rows) { return rows.rows() < 12 ? 0 : singular_values(rows)[11]; }

Rows12 stacked(const Rows12& above, const Rows12& below) {
  Rows12 both(above.rows() + below.rows(), 12);
  both << above, below;
  return both;
}

TEST(Observability, information_is_that_of_rows_differentiated_numerically) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const int poses : {0, 1, 2, 3, 5}) {
    const Frame frame = make_scene(sim::Scene::euroc_like, 60, random.seed());
    const Indices candidates = some_of(random, frame);
    std::vector<Pose> before = poses_before(random, frame, poses);
    ObservabilitySelection selection;
    for (auto pose = before.rbegin(); pose != before.rend(); ++pose) selection.add_pose(*pose);
    before.resize(std::min<std::size_t>(before.size(), 3));  // the last three segments count
    const auto rows = observability_rows(frame, candidates, before);
    const auto information = selection.information(frame, candidates);
    ASSERT_EQ(information.size(), candidates.size());
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      EXPECT_LT(relative_difference(information[c], gram(rows[c])), 1e-7) << poses << " poses";
    }
  }
}

TEST(Observability, a_match_behind_the_camera_informs_of_nothing) {
  Frame frame = make_scene(sim::Scene::euroc_like, 10, 1);
  const Eigen::Vector3d behind = sim::pose_of(frame.T_cw_prior).inverse() * Eigen::Vector3d(0.1, 0.2, -3);
  for (int i = 0; i < 3; ++i) frame.matches[4].point[i] = behind[i];
  const auto information = ObservabilitySelection().information(frame, {3, 4});
  EXPECT_GT(information[0].norm(), 0);
  EXPECT_EQ(information[1].norm(), 0);
}

// The same samples, and each of a sample decomposed: nobody in it is better than who was selected, by more than what
// numerical derivatives are off by.
void expect_best_of_samples(const Frame& frame, const Indices& candidates, const std::vector<Pose>& before,
                            std::size_t k, double epsilon, std::uint64_t seed) {
  ObservabilitySelection selection;
  for (auto pose = before.rbegin(); pose != before.rend(); ++pose) selection.add_pose(*pose);
  sim::Draws draws(seed), same_draws(seed);
  const Indices selected = selection.select(frame, candidates, k, epsilon, draws);
  ASSERT_EQ(selected.size(), k);
  const auto rows = observability_rows(frame, candidates, before);
  const double share = static_cast<double>(candidates.size()) / static_cast<double>(k);
  const auto sample = static_cast<std::size_t>(std::ceil(share * std::log(1 / epsilon)));
  Indices remaining(candidates.size());
  std::iota(remaining.begin(), remaining.end(), 0U);
  Rows12 stack(0, 12);
  for (const std::uint32_t chosen : selected) {
    const std::size_t looked_at = std::min(sample, remaining.size());
    same_draws.shuffle_front(remaining, looked_at);
    double best = 0;
    std::size_t winner = looked_at;
    for (std::size_t r = 0; r < looked_at; ++r) {
      best = std::max(best, smallest_singular_value(stacked(stack, rows[remaining[r]])));
      if (candidates[remaining[r]] == chosen) winner = r;
    }
    ASSERT_LT(winner, looked_at) << "not of the sample";
    stack = stacked(stack, rows[remaining[winner]]);
    EXPECT_GT(smallest_singular_value(stack), best * (1 - 1e-6) - 1e-6 * stack.norm());
    std::swap(remaining[winner], remaining.back());
    remaining.pop_back();
  }
}

TEST(Observability, selects_the_best_of_every_sample) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(6); trial > 0; --trial) {
    const Frame frame = make_scene(sim::Scene::euroc_like, 60, random.seed() + trial);
    const Indices candidates = some_of(random, frame);
    for (const int poses : {0, 1, 3}) {
      expect_best_of_samples(frame, candidates, poses_before(random, frame, poses), 15, 0.2, random.seed());
    }
  }
}

TEST(Observability, sees_the_least_observable_direction_better_than_random_selection) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    const Frame frame = make_scene(sim::Scene::euroc_like, 200, random.seed() + trial);
    Indices candidates = some_of(random, frame);
    const std::vector<Pose> before = poses_before(random, frame, 2);
    FeatureSelector by_observability(settings_of(SelectorKind::observability, 20, trial));
    FeatureSelector by_chance(settings_of(SelectorKind::random, 20, trial));
    by_observability.add_pose(before[1]);
    by_observability.add_pose(before[0]);
    const auto value_of = [&](const Indices& selected) {
      Rows12 stack(0, 12);
      for (const Rows12& rows : observability_rows(frame, selected, before)) stack = stacked(stack, rows);
      return smallest_singular_value(stack);
    };
    EXPECT_GT(value_of(by_observability.select(frame, candidates)), value_of(by_chance.select(frame, candidates)));
  }
}

TEST(ImageGrid, has_its_cells_row_by_row_and_edges_take_what_lies_beyond) {
  Frame frame;
  frame.width = 752;
  frame.height = 480;
  const sim::ImageGrid grid{10, 8};
  const auto cell_of = [&](double u, double v) {
    sim::Match match;
    match.u = u;
    match.v = v;
    return grid.cell_of(frame, match);
  };
  EXPECT_EQ(grid.cells(), 80U);
  EXPECT_EQ(cell_of(0, 0), 0U);
  EXPECT_EQ(cell_of(75.19, 59.99), 0U);
  EXPECT_EQ(cell_of(75.21, 59.99), 1U);
  EXPECT_EQ(cell_of(75.19, 60.01), 10U);
  EXPECT_EQ(cell_of(751.99, 479.99), 79U);
  EXPECT_EQ(cell_of(752, 480), 79U);
  EXPECT_EQ(cell_of(1e300, -5), 9U);
  EXPECT_EQ(cell_of(-1e300, std::numeric_limits<double>::infinity()), 70U);
  EXPECT_EQ(cell_of(std::nan(""), 61), 10U);
  frame.width = frame.height = 0;
  EXPECT_LT(cell_of(300, 200), 80U) << "an image of unknown size";
}

}  // namespace
}  // namespace maxlogdet::test
