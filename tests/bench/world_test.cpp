// SPDX-License-Identifier: MIT
// What simulations are made of: random numbers, their text, poses against the matrix exponential, errors of
// trajectories against their definition, properties of all selectors, and those of blocks against direct calls of the
// library.
#include "bench/does_the_paper_hold/trajectory.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/feature_selector.hpp"
#include "bench/world/se3.hpp"
#include "bench/world/table.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <unsupported/Eigen/MatrixFunctions>

namespace maxlogdet::test {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using sim::Draws;
using sim::FeatureSelector;
using sim::pi;
using sim::SelectorKind;
using sim::SelectorSettings;
using Indices = Subset;
using Poses = std::vector<sim::StampedPose>;

// Every bound is five deviations of the sample's moment.
TEST(Draws, normal_ones_have_the_moments_of_a_standard_normal) {
  TracedRandom random;
  Draws draws(random.seed());
  const std::size_t n = trials(200000);
  const double deviation = 1 / std::sqrt(static_cast<double>(n));
  double moments[5] = {};
  double neighbours = 0, squares_of_neighbours = 0, before = draws.normal();
  for (std::size_t i = 0; i < n; ++i) {
    const double x = draws.normal();
    double power = 1;
    for (double& moment : moments) {
      moment += power / static_cast<double>(n);
      power *= x;
    }
    neighbours += x * before / static_cast<double>(n);
    squares_of_neighbours += (x * x - 1) * (before * before - 1) / static_cast<double>(n);
    before = x;
  }
  EXPECT_NEAR(moments[1], 0, 5 * deviation);
  EXPECT_NEAR(moments[2], 1, 5 * std::sqrt(2) * deviation);
  EXPECT_NEAR(moments[3], 0, 5 * std::sqrt(15) * deviation);
  EXPECT_NEAR(moments[4], 3, 5 * std::sqrt(96) * deviation);
  EXPECT_NEAR(neighbours, 0, 5 * deviation);
  EXPECT_NEAR(squares_of_neighbours, 0, 5 * 2 * deviation);
}

TEST(Draws, streams_share_no_number) {
  std::set<std::uint64_t> numbers;
  const auto add = [&](Draws draws) {
    for (int i = 0; i < 50; ++i) numbers.insert(draws.bits());
  };
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    add(Draws(seed));
    for (std::uint64_t stream = 0; stream < 20; ++stream) add(Draws(seed, stream));
  }
  EXPECT_EQ(numbers.size(), 50U * 20 * 21);
  EXPECT_EQ(Draws(3, 4).bits(), Draws(3, 4).bits());
}

TEST(Fixed, has_that_many_decimals) {
  EXPECT_EQ(sim::fixed(1.2345, 2), "1.23");
  EXPECT_EQ(sim::fixed(-0.06, 1), "-0.1");
  EXPECT_EQ(sim::fixed(12, 0), "12");
  EXPECT_EQ(sim::fixed(nan, 3), "-");
  const double large = -std::numeric_limits<double>::max();
  EXPECT_EQ(std::strtod(sim::fixed(large, 3).c_str(), nullptr), large) << "no digit is cut";
}

Vector6 random_xi(Random& random, double angle) {
  Vector6 xi;
  xi << 5 * random_vector(random, 1), angle * random_vector(random, 1).normalized();
  return xi;
}

Eigen::Matrix4d exponential(const Vector6& xi) {
  Eigen::Matrix4d hat = Eigen::Matrix4d::Zero();
  for (int j = 0; j < 3; ++j) hat.col(j).head<3>() = xi.tail<3>().cross(Vector3d::Unit(j));
  hat.topRightCorner<3, 1>() = xi.head<3>();
  return hat.exp();
}

TEST(Se3, exp_is_the_matrix_exponential_and_log_its_inverse_at_every_angle) {
  TracedRandom random;
  for (const double angle :
       {0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1.0, 2.5, 3.0, 3.14, pi - 1e-6, pi - 1e-9, pi - 1e-12}) {
    SCOPED_TRACE(angle);
    for (std::size_t trial = trials(20); trial > 0; --trial) {
      const Vector6 xi = random_xi(random, angle), turns = random_xi(random, random.uniform(pi, 30));
      const Pose T = sim::exp_se3(xi);
      EXPECT_LT((T.matrix() - exponential(xi)).cwiseAbs().maxCoeff(), 2e-13);
      EXPECT_LT((sim::exp_se3(turns).matrix() - exponential(turns)).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_TRUE(T.linear().isUnitary(1e-14));
      const Vector6 error = sim::log_se3(T) - xi;
      EXPECT_LT(error.head<3>().norm(), 1e-13);
      EXPECT_LE(error.tail<3>().norm(), 1e-14 * angle) << "a small rotation keeps its digits";
      EXPECT_NEAR(sim::rotation_angle(T.linear()), angle, 1e-14 * angle);
      EXPECT_NEAR(sim::rotation_angle(T.linear().transpose()), angle, 1e-14 * angle);
      EXPECT_LT((sim::skew(xi.head<3>()) * xi.tail<3>() - xi.head<3>().cross(xi.tail<3>())).norm(), 1e-14);
    }
  }
}

TEST(Se3, cameras_are_as_far_apart_as_their_centres_and_turned_by_the_angle_between_them) {
  const std::array<double, 12> rows = {0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6};  // at (-5, 4, -6)
  const Pose a = sim::pose_of(rows), b(Eigen::Translation3d(5, -4, 9));
  EXPECT_EQ(a * Vector3d(1, 2, 3), Vector3d(2, 6, 9));
  EXPECT_EQ(sim::to_rows(a), rows);
  EXPECT_NEAR(sim::camera_distance(a, b), 3, 1e-12);
  EXPECT_NEAR(sim::camera_angle_deg(a, b), 90, 1e-10);
}

class TrajectoryReader : public TextFolder {};

TEST_F(TrajectoryReader, reads_a_folder_in_order_and_names_the_line_that_is_wrong) {
  const Lines good = {"# timestamp tx ty tz qx qy qz qw", "1403636580.83856 4.688319 -1.786938 0.783338 0 0 0 1.009",
                      "\t1403636580.88856  4.5\t-1.5 0.75 0 0 0.6 0.8 # a comment\r",
                      "1403636580.93856 -4 1e-3 0 0.5 -0.5 0.5 -0.5"};
  for (const char* const name : {"V2.txt", "V1_01.txt"}) write(name, good);
  write("A.csv", {"not a trajectory"});
  const auto trajectories = sim::read_trajectories(folder_);
  ASSERT_EQ(trajectories.size(), 2U);
  EXPECT_EQ(trajectories[0].name, "V1_01");
  const Poses& poses = trajectories[0].poses;
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(poses[0].time, 1403636580.83856);
  EXPECT_EQ(poses[0].T_wb.translation(), Vector3d(4.688319, -1.786938, 0.783338));
  EXPECT_TRUE(poses[0].T_wb.linear().isIdentity(1e-15));
  const Eigen::AngleAxisd about_z(2 * std::acos(0.8), Vector3d::UnitZ());
  EXPECT_TRUE(poses[1].T_wb.linear().isApprox(about_z.toRotationMatrix(), 1e-15));
  EXPECT_LT((poses[2].T_wb.linear() * Vector3d(1, 2, 3) - Vector3d(3, -1, -2)).norm(), 1e-14);

  std::filesystem::remove(path("V1_01.txt"));
  const std::vector<BrokenLine> broken = {
      {3, "5 0 0 0 0 0 1", "expected 8 fields 'timestamp tx ty tz qx qy qz qw', not 7"},
      {2, "1 0 nan 0 0 0 0 1", "expected a finite number for ty, not 'nan'"},
      {3, "1403636580.83856 0 0 0 0 0 0 1", "expected a timestamp later than that of the pose before"},
      {2, "1 0 0 0 0 0 0 1.011", "expected a quaternion qx qy qz qw of norm 1 within 0.01"},
  };
  expect_every_one_refused("V2.txt", good, broken, [&] { sim::read_trajectories(folder_); });
  write("V2.txt", {good[1], good[2]});
  expect_input_error([&] { sim::read_trajectories(folder_); }, path("V2.txt") + ":2", "expected at least 3 poses");
}

Matrix3Xd positions_of(const Poses& poses) {
  Matrix3Xd positions(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = poses[i].T_wb.translation();
  }
  return positions;
}

// Horn, Closed-form solution of absolute orientation using unit quaternions, 1987: a similarity, and its scale.
std::pair<Eigen::Matrix4d, double> horn(const Matrix3Xd& from, const Matrix3Xd& to) {
  const Vector3d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  const Matrix3Xd p = from.colwise() - from_mean, q = to.colwise() - to_mean;
  const Eigen::Matrix3d M = product(p, q.transpose());
  const Vector3d skewed(M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0));
  Eigen::Matrix4d N;
  N << M.trace(), skewed.transpose(), skewed, M + M.transpose() - M.trace() * Eigen::Matrix3d::Identity();
  const Eigen::Vector4d w = spectrum(N).vectors.col(3);
  const Eigen::Matrix3d R = Eigen::Quaterniond(w[0], w[1], w[2], w[3]).normalized().toRotationMatrix();
  const double scale = q.cwiseProduct(product(R, p)).sum() / p.squaredNorm();
  Eigen::Matrix4d similarity = Eigen::Matrix4d::Identity();
  similarity.topRows<3>() << scale * R, to_mean - scale * R * from_mean;
  return {similarity, scale};
}

// By 4 x 4 matrices, general inverses, every pair of poses, and Horn's alignment.
sim::TrajectoryErrors errors_by_definition(const Poses& estimate, const Poses& truth, double window) {
  const auto [similarity, scale] = horn(positions_of(estimate), positions_of(truth));
  std::vector<Eigen::Matrix4d> aligned;
  sim::TrajectoryErrors errors;
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    aligned.emplace_back(product(similarity, estimate[i].T_wb.matrix()));
    aligned[i].topLeftCorner<3, 3>() /= scale;
    squares += (aligned[i] - truth[i].T_wb.matrix()).col(3).squaredNorm();
  }
  errors.ate_m = std::sqrt(squares / static_cast<double>(truth.size()));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    std::size_t j = i + 1;
    while (j < truth.size() && truth[j].time - truth[i].time < window - 0.5e-6) ++j;
    if (j == truth.size() || truth[j].time - truth[i].time > window + 0.5) continue;
    const double time = truth[j].time - truth[i].time;
    const Eigen::Matrix4d true_motion = product(inverse(truth[i].T_wb.matrix()), truth[j].T_wb.matrix());
    const Eigen::Matrix4d drift = product(inverse(true_motion), product(inverse(aligned[i]), aligned[j]));
    errors.rpe_m_per_s += drift.topRightCorner<3, 1>().norm() / time;
    errors.roe_deg_per_s += 180 / pi * Eigen::AngleAxisd(Eigen::Matrix3d(drift.topLeftCorner<3, 3>())).angle() / time;
    ++errors.windows;
  }
  errors.rpe_m_per_s /= static_cast<double>(errors.windows);
  errors.roe_deg_per_s /= static_cast<double>(errors.windows);
  return errors;
}

TEST(TrajectoryErrors, are_those_of_the_definition_also_over_missing_poses) {
  TracedRandom random;
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    Poses truth, estimate;
    double time = 1403636580.83856;
    Pose T = random_isometry(random, 5, 1);
    const double noise = random.uniform(0, 0.5), window = random.uniform(0.5, 4);
    const double scale = std::exp(random.uniform(-2, 2));
    const Pose moved = random_isometry(random, 10, 3);
    for (int i = 0; i < 240; ++i) {
      time += random.chance(0.02) ? random.uniform(0.2, 2) : random.uniform(0.03, 0.07);
      T = T * random_isometry(random, 0.1, 0.1);
      truth.push_back({time, T});
      estimate.push_back({time, moved * T * random_isometry(random, noise, noise)});
      estimate.back().T_wb.translation() *= scale;
    }
    const auto errors = sim::trajectory_errors(estimate, truth, window);
    const auto expected = errors_by_definition(estimate, truth, window);
    EXPECT_NEAR(errors.ate_m, expected.ate_m, 1e-10);
    EXPECT_NEAR(errors.rpe_m_per_s, expected.rpe_m_per_s, 1e-10);
    EXPECT_NEAR(errors.roe_deg_per_s, expected.roe_deg_per_s, 1e-8);
    EXPECT_EQ(errors.windows, expected.windows);
    EXPECT_GT(errors.windows, 0U);
  }
}

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

// Of several cells bucket prefers none. Both shuffle.
TEST(FeatureSelector, random_and_bucket_select_uniformly) {
  Frame frame = make_scene(sim::Scene::euroc_like, 40, 3);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    frame.matches[i].u = i % 4 < 2 ? 10 : 700;
    frame.matches[i].v = i % 2 == 0 ? 10 : 400;
  }
  Indices candidates(20);
  std::iota(candidates.begin(), candidates.end(), 10U);
  constexpr std::size_t budget = 5;
  for (const SelectorKind kind : {SelectorKind::random, SelectorKind::bucket}) {
    SCOPED_TRACE(to_string(kind));
    SelectorSettings settings = settings_of(kind, budget);
    settings.grid = {2, 2};
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

TEST(FeatureSelector, quality_md_is_the_library_among_the_best_by_quality_and_md_among_all_candidates) {
  TracedRandom random;
  for (const Strategy strategy : {Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
    SelectorSettings settings = settings_of(SelectorKind::md, 60);
    settings.search = with_budget(60, strategy);
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
      EXPECT_EQ(md.select(frame, candidates), selected_by_library(frame, candidates, settings.search));
      EXPECT_EQ(quality_md.select(frame, candidates),
                selected_by_library(frame, best_by_quality(frame, candidates, 90), settings.search));
      EXPECT_EQ(FeatureSelector(settings_of(SelectorKind::quality, 40)).select(frame, candidates),
                best_by_quality(frame, candidates, 40));
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
