// SPDX-License-Identifier: MIT
#include "sim/feature_selector.hpp"
#include "sim/allocation_counter.hpp"

#include "tests/decompositions.hpp"
#include "tests/linear_algebra.hpp"
#include "tests/support.hpp"

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
  for (const K kind : {K::quality, K::bucket, K::observability, K::md, K::quality_md, K::random}) {
    EXPECT_TRUE(has_budget(kind) && rejects_outliers(kind)) << to_string(kind);
  }
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
    const bool draws =
        kind == SelectorKind::random || kind == SelectorKind::bucket || kind == SelectorKind::observability;
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
