// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"
#include "bench/world/table.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Table I of the paper: metrics that select a subset of rows, Q = 1e-5 I + sum of selected H^T H.
enum class GreedyMetric {
  max_log_det,         ///< log det Q, by this library
  max_trace,           ///< tr Q
  min_condition,       ///< lambda_max(Q) / lambda_min(Q)
  max_min_eigenvalue,  ///< lambda_min(Q)
};

constexpr GreedyMetric greedy_metrics[] = {GreedyMetric::max_log_det, GreedyMetric::max_trace,
                                           GreedyMetric::min_condition, GreedyMetric::max_min_eigenvalue};

/// Returns all valid candidates in greedy's order: its first k are the greedy selection of k. Ties go to the lowest
/// index, and values that differ by less than rounding are ties: the smallest eigenvalue is only rounding while Q lacks
/// a direction.
std::vector<std::uint32_t> greedy_order(GreedyMetric metric, const BlockStore& blocks);

/// Section III of the paper: pose from perfectly matched points of a biased map, with subsets chosen by each metric.
struct MetricsOptions {
  std::size_t points = 200;
  std::vector<double> noises = {1, 2};  ///< px
  std::vector<std::size_t> sizes = {80, 90, 100, 110, 120, 130, 140, 150, 160, 170, 180, 190, 200};
  double map_bias = 0.05;       ///< m, mean of the map error, in each of x, y, z
  double map_deviation = 0.05;  ///< m
  std::uint64_t seed = 0;
};

/// In the order of a run's errors: the metrics, `random`, and `all` points, whatever the size.
constexpr const char* metrics_selectors[] = {"max_log_det",        "max_trace", "min_condition",
                                             "max_min_eigenvalue", "random",    "all"};

/// One draw of everything that a run needs. Noises are multiples of the same draw, so that panels differ in noise
/// alone. The tracker guesses that the camera has not moved from the world's origin.
struct MetricsScene {
  Pose true_T_cw = Pose::Identity();
  std::vector<Match> matches;                ///< map points, and true pixels
  std::vector<std::array<double, 2>> noise;  ///< of u and v, of deviation 1
  std::vector<std::uint32_t> random_order;

  /// The frame that a tracker sees.
  Frame frame(double noise_px) const;
};
MetricsScene draw_metrics_scene(const MetricsOptions& options, std::uint64_t run);

/// Of an estimated pose; NaN without a usable estimate.
struct PoseError {
  double translation_m = 0;  ///< of the camera centre
  double rotation_deg = 0;
};

/// The errors of a run, by noise, selector and size.
using MetricsRun = std::vector<std::vector<std::vector<PoseError>>>;

/// Computes a run: deterministic in options and run. Poses are by Gauss-Newton; metrics see the paper's H_c.
MetricsRun run_metrics(const MetricsOptions& options, std::uint64_t run);

/// By noise, size and selector, the root mean square over runs of both errors, with its interval (jackknife).
Table metrics_table(const MetricsOptions& options, const std::vector<MetricsRun>& runs);

/// By noise, selector and error, the mean over sizes of these, with its interval and the verdict on max_log_det. The
/// size of all points, where all selectors agree, is left out.
Table metrics_means(const MetricsOptions& options, const std::vector<MetricsRun>& runs);

}  // namespace maxlogdet::sim
