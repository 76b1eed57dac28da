// SPDX-License-Identifier: MIT
// Sections III and IV of the paper: metrics against brute force, samples against Algorithm 1, tables by hand. And the
// benchmarks' baselines, which find what the library finds, so that their times can be compared, in frames whose map
// has the errors that its covariances say.
#include "bench/does_the_paper_hold/epsilon.hpp"
#include "bench/does_the_paper_hold/estimate.hpp"
#include "bench/does_the_paper_hold/metrics.hpp"
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/scene.hpp"
#include "bench/world/tracker_frames.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>
#include <maxlogdet/eigen.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

using Indices = std::vector<std::uint32_t>;
using sim::EpsilonOptions;
using sim::EpsilonOutcome;
using sim::GreedyMetric;
using sim::MetricsOptions;
using sim::MetricsRun;

// The definition, by decomposing every candidate in every round. Values of eigenvalues that differ by less than
// rounding are ties, which go to the lowest index.
Indices textbook_greedy(GreedyMetric metric, const BlockStore& blocks, std::size_t k) {
  if (metric == GreedyMetric::max_log_det) return GreedyOracle<double>(blocks, weak_information()).select(k);
  std::vector<bool> is_taken(blocks.size());
  Indices selected;
  Matrix6 Q = weak_information();
  while (selected.size() < k) {
    std::optional<std::uint32_t> winner;
    double best = 0;
    for (std::uint32_t i = 0; i < blocks.size(); ++i) {
      if (is_taken[i] || !blocks.is_valid(i)) continue;
      const Matrix6 with_it = Q + gram(stored_block(blocks, i));
      const Vector6 values = eigenvalues(with_it);
      const double value = metric == GreedyMetric::max_trace       ? with_it.trace()
                           : metric == GreedyMetric::min_condition ? -values[5] / values[0]
                                                                   : values[0];
      const double tie = 1e-13 * (metric == GreedyMetric::min_condition ? best * best : with_it.trace());
      if (winner && !(value > best + tie)) continue;
      winner = i;
      best = value;
    }
    selected.push_back(*winner);
    is_taken[*winner] = true;
    Q += gram(stored_block(blocks, *winner));
  }
  return selected;
}

// Least squares of reprojection errors, differentiated numerically, from the origin.
sim::Pose pose_by_brute_force(const sim::Frame& frame, const Indices& subset) {
  const auto moved = [](const sim::Pose& T, const Vector6& xi) {
    const Eigen::Vector3d turn = xi.tail<3>();
    return Eigen::Translation3d(xi.head<3>()) * Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()) * T;
  };
  const auto residuals = [&](const sim::Pose& T) {
    Eigen::VectorXd e(2 * static_cast<Eigen::Index>(subset.size()));
    Eigen::Index row = 0;
    for (const std::uint32_t i : subset) {
      const sim::Match& match = frame.matches[i];
      const Eigen::Vector3d p = T * Eigen::Vector3d(match.point);
      e[row++] = match.u - sim::euroc_camera.fx * p.x() / p.z() - sim::euroc_camera.cx;
      e[row++] = match.v - sim::euroc_camera.fy * p.y() / p.z() - sim::euroc_camera.cy;
    }
    return e;
  };
  sim::Pose T = sim::Pose::Identity();
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::MatrixXd J(2 * static_cast<Eigen::Index>(subset.size()), 6);
    for (int j = 0; j < 6; ++j) {
      const Vector6 step = 1e-6 * Vector6::Unit(j);
      J.col(j) = (residuals(moved(T, -step)) - residuals(moved(T, step))) / 2e-6;
    }
    T = moved(T, solve_least_squares(J, residuals(T)));
  }
  return T;
}

MetricsOptions small_options() {
  MetricsOptions options;
  options.points = 40;
  options.sizes = {15, 40};
  return options;
}

TEST(Metrics, errors_are_those_of_poses_by_brute_force) {
  const MetricsOptions options = small_options();
  for (const std::uint64_t number : {0U, 7U}) {
    const sim::MetricsScene scene = draw_metrics_scene(options, number);
    const MetricsRun run = run_metrics(options, number);
    for (std::size_t n = 0; n < options.noises.size(); ++n) {
      const sim::Frame frame = scene.frame(options.noises[n]);
      for (std::size_t s = 0; s < std::size(sim::metrics_selectors); ++s) {
        const std::string selector = sim::metrics_selectors[s];
        SCOPED_TRACE(selector);
        Indices order = scene.random_order;
        if (s < 4) order = textbook_greedy(sim::greedy_metrics[s], paper_blocks(frame, all_matches(frame)), 15);
        if (selector != "all") order.resize(15);
        const sim::Pose T = pose_by_brute_force(frame, order);
        const sim::PoseError error = run[n][s][0];
        EXPECT_NEAR(error.translation_m, (T.inverse().translation() - scene.true_T_cw.inverse().translation()).norm(),
                    1e-7);
        const Eigen::Matrix3d turn = T.linear() * scene.true_T_cw.linear().transpose();
        EXPECT_NEAR(error.rotation_deg, Eigen::AngleAxisd(turn).angle() * 180 / 3.141592653589793, 1e-5);
        EXPECT_NEAR(run[n][s][1].translation_m, run[n][5][0].translation_m, 1e-7) << "a selection of all is all";
      }
    }
  }
}

TEST(Metrics, scenes_have_the_errors_of_the_paper) {
  MetricsOptions options;
  options.points = 20000;
  const sim::Frame noisy = draw_metrics_scene(options, 0).frame(2);
  options.map_bias = options.map_deviation = 0;
  const sim::MetricsScene exact = draw_metrics_scene(options, 0);
  Eigen::Array2d sums(0, 0), squares(0, 0);  // of errors of the map, and of pixels
  for (std::size_t i = 0; i < options.points; ++i) {
    const sim::Match &match = noisy.matches[i], &truth = exact.matches[i];
    EXPECT_NEAR(truth.point[2], 11, 9);
    const double off = match.point[i % 3] - truth.point[i % 3];
    const Eigen::Array2d errors((off - 0.05) / 0.05, (i % 2 == 0 ? match.u - truth.u : match.v - truth.v) / 2);
    sums += errors;
    squares += errors.square();
  }
  const auto n = static_cast<double>(options.points);
  EXPECT_LT((sums / n).abs().maxCoeff(), 5 / std::sqrt(n));
  EXPECT_LT((squares / n - 1).abs().maxCoeff(), 5 * std::sqrt(2 / n));
}

// A difference of 20 % is significant against a shared spread of 10 %; a difference of 0 with an independent spread is
// not.
TEST(Metrics, tables_have_root_mean_squares_and_verdicts) {
  const MetricsOptions options = small_options();
  std::vector<MetricsRun> runs(70);
  for (std::size_t run = 0; run < runs.size(); ++run) {
    const auto spread = [](std::size_t i) { return 1 + 0.1 * (static_cast<double>(i % 7) - 3) / 3; };
    for (const double noise : options.noises) {
      runs[run].emplace_back();
      for (const std::string selector : sim::metrics_selectors) {
        const double scale = selector == "max_trace" ? 1.2 : selector == "all" ? 0.8 : 1;
        const double e = noise * scale * spread(selector == "random" ? run + 3 : run);
        runs[run].back().push_back({{e, 2 * e}, {1000, 1000}});  // that of all points is left out of means
      }
    }
  }
  // Mean square of 1 + 0.1 (-3 ... 3) / 3: 1 + 0.01 * 4 / 9.
  const double rms = std::sqrt(1 + 0.04 / 9);
  const sim::Table table = metrics_table(options, runs), means = metrics_means(options, runs);
  ASSERT_EQ(table.rows.size(), 2U * 2 * 6);
  const auto& row = table.rows[12];
  EXPECT_EQ(row[0] + ' ' + row[1] + ' ' + row[2], "2 15 max_log_det");
  EXPECT_EQ(row[3], sim::fixed(2 * rms, 5));
  EXPECT_EQ(row[5], sim::fixed(4 * rms, 5));
  // 1.96 times the deviation of the squares over 2 rms sqrt(n), as the jackknife has it for many runs.
  EXPECT_NEAR(std::stod(row[4]), 2 * 1.96 * 0.1336 / (2 * rms * std::sqrt(70)), 0.001);

  ASSERT_EQ(means.rows.size(), 6U * 2 * 2);
  for (const auto& cells : means.rows) {
    const std::string expected = cells[0] == "max_log_det" ? ""
                                 : cells[0] == "max_trace" ? "better"
                                 : cells[0] == "all"       ? "worse"
                                                           : "open";
    EXPECT_EQ(cells[5], expected) << cells[0];
  }
  EXPECT_EQ(means.rows[0][3], sim::fixed(rms, 4)) << "translation at 1 px";
  EXPECT_EQ(means.rows[3][3], sim::fixed(4 * rms, 4)) << "rotation at 2 px";
  EXPECT_EQ(means.rows[4][3], sim::fixed(1.2 * rms, 4)) << "max_trace";
  EXPECT_NEAR(sim::mean_of({1, 2}).ci95, 6.3531, 1e-4) << "Student's 12.7062 / 2";
  EXPECT_STREQ(sim::verdict(sim::mean_of({7})), "open") << "one value has no interval";
}

// Draws the frame and selects again; log determinants are those of the indices, in long double. Sample sizes of
// Algorithm 1 are ceil(n / k ln(1 / epsilon)), and at most the remaining candidates.
TEST(Epsilon, shares_and_gains_are_those_of_the_selections) {
  EpsilonOptions options;
  options.shares = {0.1, 0.5};
  options.epsilons = {0.5, 0.05};
  options.seed = 3;
  sim::Draws seeds(3, 7);
  const Frame frame = make_scene(sim::Scene::euroc_like, 150, seeds.bits());
  const BlockStore blocks = paper_blocks(frame, all_matches(frame));
  const Matrix6 prior = weak_information();
  const auto f = [&](const Indices& indices) {
    return static_cast<double>(log_det_of(blocks, indices, prior)) - 6 * std::log(weak_prior);
  };
  const auto outcomes = run_epsilon(options, 150, 7);
  ASSERT_EQ(outcomes.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    Options search = with_budget(i < 2 ? 15 : 75, Strategy::stochastic_greedy);
    search.prior = prior.data();
    search.stochastic.epsilon = i % 2 == 0 ? 0.5 : 0.05;
    search.stochastic.seed = seeds.bits();
    const double of_greedy = f(GreedyOracle<double>(blocks, prior).select(search.budget));
    EXPECT_EQ(outcomes[i].k, search.budget);
    const double k = static_cast<double>(search.budget), sample = std::ceil(-150 / k * std::log(outcomes[i].epsilon));
    double gains = 0;
    for (double left = 150; left > 150 - k; --left) gains += std::min(sample, left);
    EXPECT_EQ(outcomes[i].gains, gains);
    EXPECT_EQ(outcomes[i].gains_greedy, k * (150 + 151 - k) / 2) << "150 + 149 + ...";
    EXPECT_EQ(outcomes[i].epsilon, search.stochastic.epsilon);
    EXPECT_NEAR(outcomes[i].share_of_greedy, f(select_indices(blocks, search)) / of_greedy, 1e-9);
    EXPECT_GE(outcomes[i].share_of_greedy, 1 - std::exp(-1) - outcomes[i].epsilon) << "the guarantee";
    for (const double us : {outcomes[i].us, outcomes[i].us_greedy, outcomes[i].us_lazy}) EXPECT_GT(us, 0);
  }
}

TEST(Epsilon, the_table_averages_what_it_names) {
  EpsilonOptions options;
  options.epsilons = {0.5, 0.1};
  const std::vector<EpsilonOutcome> outcomes = {{1000, 100, 0.5, 2, 20, 6, 70, 955, 0.9},
                                                {1000, 100, 0.1, 4, 20, 6, 240, 955, 0.99},
                                                {1000, 100, 0.5, 4, 20, 8, 70, 955, 0.8},
                                                {1000, 100, 0.1, 4, 40, 8, 240, 955, 1.01},
                                                {200, 100, 0.1, 1, 100, 8, 10, 1955, 0.5}};
  EXPECT_EQ(sim::to_csv(epsilon_table(options, outcomes)),
            "n and k,epsilon,guarantee,minimum of greedy,fewer evaluations,faster than greedy,faster than lazy greedy\n"
            "all,0.5,0.132,0.8000,13.6,7.5,2.5\n"
            "all,0.1,0.532,0.5000,67.8,38.3,3.8\n"
            "n = 1000 k = 100,0.5,0.132,0.8000,13.6,7.5,2.5\n"
            "n = 1000 k = 100,0.1,0.532,0.9900,4.0,7.5,1.8\n");
}

class EigenBaselines : public testing::TestWithParam<sim::TrackerKind> {};

// The library rounds medians to 12 bits, so that a match whose error is next to the limit may be on either side.
TEST_P(EigenBaselines, find_the_inliers_but_for_ties_and_the_pose_of_the_library) {
  constexpr std::uint64_t frames = 20;
  std::size_t with_ties = 0;
  for (std::uint64_t seed = 1; seed <= frames; ++seed) {
    SCOPED_TRACE(seed);
    const sim::TrackerFrame frame(GetParam(), 465, seed);
    const PinholeCamera& camera = frame.frame.camera;
    GoodFeatures good(frame.measured.size());
    good.start(camera, frame.T_predicted);
    for (const FeatureMatch& match : frame.measured) good.add(match);
    const Alignment found = good.align();
    ASSERT_TRUE(found.is_aligned());
    EXPECT_NEAR(found.scale, 1, 0.25) << "errors are as large as deviations and covariances say";
    good.outliers(good.pose());
    bench::EigenAligner eigen;
    ASSERT_TRUE(eigen.align(camera, frame.T_predicted, frame.measured));
    bool has_ties = false;
    for (std::size_t i = 0; i < frame.measured.size(); ++i) {
      if (eigen.is_inlier(i) == good.is_inlier(i)) continue;
      const double limit = frame.measured[i].u_right >= 0 ? 11.345 : 9.2103;  // 99 % quantiles of chi-squared
      EXPECT_NEAR(good.chi2(i) / (found.scale * found.scale) / limit, 1, 0.01) << i;
      has_ties = true;
    }
    with_ties += has_ties ? 1 : 0;
    for (int e = 0; e < 12 && !has_ties; ++e) EXPECT_NEAR(eigen.pose().data()[e], good.pose().data()[e], 1e-6) << e;
  }
  EXPECT_LE(with_ties, frames / 4);
}

// A sample of all candidates is no sample: the answer of stochastic greedy is then greedy's.
TEST_P(EigenBaselines, select_what_lazy_greedy_selects_and_sample_what_epsilon_asks_for) {
  BlockStore store;
  sim::TrackerFrame(GetParam(), 465, 1).build(store);
  Options options;
  options.budget = 100;
  options.prior = bench::common_prior();
  Selector selector(store.size());
  const Selection selection = selector.select(store, options);
  const Indices greedy = indices_of(selection);
  const auto eigen = bench::make_eigen_selector(store);
  eigen->lazy_greedy(options.budget);
  EXPECT_EQ(eigen->indices(), greedy);
  EXPECT_NEAR(eigen->log_det(), selection.log_det, 1e-9 * std::abs(selection.log_det));
  eigen->stochastic_greedy(options.budget, 1e-50, 1);  // 4.65 ln(1e50) > 465
  EXPECT_EQ(eigen->indices(), greedy);
  eigen->stochastic_greedy(options.budget, 0.1, 1);
  EXPECT_LT(eigen->log_det(), selection.log_det);
  EXPECT_GT(eigen->log_det(), selection.log_det - 2);  // nats
}

INSTANTIATE_TEST_SUITE_P(Kinds, EigenBaselines, testing::ValuesIn(sim::tracker_kinds),
                         [](const auto& kind) { return std::string("of_") + kind.param.name; });

}  // namespace
}  // namespace maxlogdet::test
