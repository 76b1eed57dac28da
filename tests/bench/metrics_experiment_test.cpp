// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/metrics_experiment.hpp"

#include "bench/does_the_paper_hold/greedy_metric.hpp"
#include "bench/world/euroc_camera.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

using Indices = std::vector<std::uint32_t>;
using sim::GreedyMetric;
using sim::MetricsOptions;
using sim::MetricsRun;
using sim::Table;

// The definition, by decomposing every candidate in every round. Values of eigenvalues that differ by less than
// rounding are ties, which go to the lowest index.
Indices textbook_greedy(GreedyMetric metric, const BlockStore& blocks, std::size_t k) {
  Indices remaining;
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i)) remaining.push_back(i);
  }
  Indices selected;
  Matrix6 Q = weak_information();
  while (selected.size() < k && !remaining.empty()) {
    std::size_t winner = remaining.size();
    double best = 0;
    for (std::size_t r = 0; r < remaining.size(); ++r) {
      const Matrix6 with_it = Q + gram(stored_block(blocks, remaining[r]));
      const Vector6 values = eigenvalues(with_it);
      const double value = metric == GreedyMetric::max_trace       ? with_it.trace()
                           : metric == GreedyMetric::min_condition ? -values[5] / values[0]
                                                                   : values[0];
      const double tie = 1e-13 * (metric == GreedyMetric::min_condition ? best * best : with_it.trace());
      if (winner != remaining.size() && !(value > best + tie)) continue;
      winner = r;
      best = value;
    }
    selected.push_back(remaining[winner]);
    Q += gram(stored_block(blocks, remaining[winner]));
    remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(winner));
  }
  return selected;
}

Indices expected_order(GreedyMetric metric, const BlockStore& blocks, std::size_t k) {
  if (metric != GreedyMetric::max_log_det) return textbook_greedy(metric, blocks, k);
  return GreedyOracle<double>(blocks, weak_information()).select(k);
}

MetricsOptions small_options() {
  MetricsOptions options;
  options.points = 40;
  options.sizes = {15, 40};
  return options;
}

sim::Pose moved(const sim::Pose& T, const Vector6& xi) {
  const Eigen::Vector3d turn = xi.tail<3>();
  return Eigen::Translation3d(xi.head<3>()) * Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()) * T;
}

// Least squares of reprojection errors, differentiated numerically, from the origin.
sim::Pose pose_by_brute_force(const sim::MetricsScene& scene, const Indices& subset, double noise) {
  const auto residuals = [&](const sim::Pose& T) {
    Eigen::VectorXd e(2 * static_cast<Eigen::Index>(subset.size()));
    for (std::size_t r = 0; r < subset.size(); ++r) {
      const sim::Match& match = scene.matches[subset[r]];
      const Eigen::Vector3d p = T * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
      const auto row = 2 * static_cast<Eigen::Index>(r);
      e[row] =
          match.u + noise * scene.noise[subset[r]][0] - sim::euroc_camera.fx * p.x() / p.z() - sim::euroc_camera.cx;
      e[row + 1] =
          match.v + noise * scene.noise[subset[r]][1] - sim::euroc_camera.fy * p.y() / p.z() - sim::euroc_camera.cy;
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

TEST(Metrics, errors_are_those_of_poses_by_brute_force) {
  const MetricsOptions options = small_options();
  const auto selectors = sim::metrics_selectors();
  for (const std::uint64_t number : {0U, 7U}) {
    const sim::MetricsScene scene = draw_metrics_scene(options, number);
    const MetricsRun run = run_metrics(options, number);
    for (std::size_t n = 0; n < options.noises.size(); ++n) {
      sim::Frame frame;
      frame.camera = sim::euroc_camera;
      frame.matches = scene.matches;
      for (sim::Match& match : frame.matches) match.inv_sigma2 = 1 / (options.noises[n] * options.noises[n]);
      BlockOptions block_options;
      block_options.weighting = Weighting::map_bias;
      BlockStore blocks;
      build_blocks(frame, block_options, blocks);
      for (std::size_t s = 0; s < selectors.size(); ++s) {
        SCOPED_TRACE(selectors[s]);
        Indices order = scene.random_order;
        if (s < std::size(sim::greedy_metrics)) order = expected_order(sim::greedy_metrics[s], blocks, 40);
        if (selectors[s] != "all") order.resize(15);
        const sim::Pose T = pose_by_brute_force(scene, order, options.noises[n]);
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
  const sim::MetricsScene scene = draw_metrics_scene(options, 0);
  options.map_bias = options.map_deviation = 0;
  const sim::MetricsScene exact = draw_metrics_scene(options, 0);
  Eigen::Array2d sums(0, 0), squares(0, 0);  // of errors of the map, and of noise
  for (std::size_t i = 0; i < options.points; ++i) {
    EXPECT_NEAR(exact.matches[i].point[2], 11, 9);
    const double off = scene.matches[i].point[i % 3] - exact.matches[i].point[i % 3];
    const Eigen::Array2d errors((off - 0.05) / 0.05, scene.noise[i][i % 2]);
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
  const auto selectors = sim::metrics_selectors();
  std::vector<MetricsRun> runs;
  for (std::size_t run = 0; run < 70; ++run) {
    const auto spread = [](std::size_t i) { return 1 + 0.1 * (static_cast<double>(i % 7) - 3) / 3; };
    runs.emplace_back();
    for (const double noise : options.noises) {
      runs.back().emplace_back();
      for (const std::string& selector : selectors) {
        const double scale = selector == "max_trace" ? 1.2 : selector == "all" ? 0.8 : 1;
        const double e = noise * scale * spread(selector == "random" ? run + 3 : run);
        runs.back().back().push_back({{e, 2 * e}, {1000, 1000}});  // that of all points is left out of means
      }
    }
  }
  // Mean square of 1 + 0.1 (-3 ... 3) / 3: 1 + 0.01 * 4 / 9.
  const double rms = std::sqrt(1 + 0.04 / 9);
  const Table table = metrics_table(options, runs), means = metrics_means(options, runs);
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
}

}  // namespace
}  // namespace maxlogdet::test
