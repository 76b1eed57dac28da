// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/metrics.hpp"

#include "bench/does_the_paper_hold/estimate.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/pose_optimizer.hpp"
#include "bench/world/projection.hpp"
#include "bench/world/scene.hpp"

#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace maxlogdet::sim {
namespace {

// The paper says only "randomly generated in front of the camera" and "a small random pose transform".
constexpr double nearest = 2, farthest = 20;           // m, depths
constexpr double translation = 0.1, rotation_deg = 5;  // largest, along and about each axis

constexpr double prior = 1e-5;  // times I

// Bounds the error of an eigenvalue of Q, relative to its trace; the solver's is about 1e-15.
constexpr double eigenvalue_rounding = 1e-13;

Matrix6 information_of(const BlockStore& blocks, std::size_t i) {
  double entries[max_block_rows * state_dimension];
  const int rows = blocks.block(i, entries);
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> H(entries, rows, 6);
  return H.transpose() * H;
}

// Greater is better.
double value_of(GreedyMetric metric, const Matrix6& Q) {
  if (metric == GreedyMetric::max_trace) return Q.trace();
  const Vector6 eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix6>(Q, Eigen::EigenvaluesOnly).eigenvalues();
  return metric == GreedyMetric::max_min_eigenvalue ? eigenvalues[0] : -eigenvalues[5] / eigenvalues[0];
}

std::vector<std::uint32_t> order_by_log_det(const BlockStore& blocks, std::size_t k) {
  const Matrix6 information = prior * Matrix6::Identity();
  Options options;
  options.budget = k;
  options.prior = information.data();
  Selector selector(blocks.size());
  const Selection selection = selector.select(blocks, options);
  if (!selection.has_answer()) throw std::invalid_argument(to_string(selection.status));
  return {selection.begin(), selection.end()};
}

PoseError error_with(const Frame& frame, const std::vector<std::uint32_t>& subset, const Pose& true_T_cw) {
  PoseOptions options;
  options.method = PoseMethod::gauss_newton;
  options.max_iterations = 20;
  const PoseEstimate estimate = optimize_pose(frame.camera, frame.matches, subset, Pose::Identity(), options);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (!estimate.is_usable()) return {nan, nan};
  return {camera_distance(estimate.T_cw, true_T_cw), camera_angle_deg(estimate.T_cw, true_T_cw)};
}

// Both panels of a noise.
struct Part {
  const char* name;
  double PoseError::*error;
};
constexpr Part parts[] = {{"rms_translation_m", &PoseError::translation_m},
                          {"rms_rotation_deg", &PoseError::rotation_deg}};

// The mean over sizes, by number, of the root mean square over runs.
Jackknifed rms_of(const std::vector<MetricsRun>& runs, std::size_t noise, std::size_t selector, const Part& part,
                  const std::vector<std::size_t>& sizes) {
  const auto n = static_cast<double>(runs.size());
  Jackknifed rms;
  rms.without.resize(runs.size());
  const double share = 1 / static_cast<double>(sizes.size());
  for (const std::size_t size : sizes) {
    const auto square_of = [&](const MetricsRun& run) {
      const double e = run[noise][selector][size].*part.error;
      return e * e;
    };
    double sum = 0;
    for (const MetricsRun& run : runs) sum += square_of(run);
    rms.value += share * std::sqrt(sum / n);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      rms.without[i] += share * std::sqrt(std::max(sum - square_of(runs[i]), 0.0) / (n - 1));
    }
  }
  return rms;
}

Jackknifed difference(Jackknifed ours, const Jackknifed& theirs) {
  ours.value -= theirs.value;
  for (std::size_t i = 0; i < ours.without.size(); ++i) ours.without[i] -= theirs.without[i];
  return ours;
}

}  // namespace

std::vector<std::uint32_t> greedy_order(GreedyMetric metric, const BlockStore& blocks) {
  std::vector<Matrix6> information(blocks.size());
  std::vector<std::uint32_t> remaining;
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (!blocks.is_valid(i)) continue;
    information[i] = information_of(blocks, i);
    remaining.push_back(i);
  }
  if (metric == GreedyMetric::max_log_det) return order_by_log_det(blocks, remaining.size());
  std::vector<std::uint32_t> order;
  Matrix6 Q = prior * Matrix6::Identity();
  while (!remaining.empty()) {
    auto winner = remaining.begin();
    double best = value_of(metric, Q + information[*winner]);
    for (auto candidate = winner + 1; candidate != remaining.end(); ++candidate) {
      const Matrix6 with_it = Q + information[*candidate];
      const double value = value_of(metric, with_it);
      const double scale = metric == GreedyMetric::min_condition ? best * best : with_it.trace();
      if (!(value > best + eigenvalue_rounding * scale)) continue;
      winner = candidate;
      best = value;
    }
    order.push_back(*winner);
    Q += information[*winner];
    remaining.erase(winner);
  }
  return order;
}

Frame MetricsScene::frame(double noise_px) const {
  Frame frame;
  frame.camera = euroc_camera;
  frame.width = euroc_width;
  frame.height = euroc_height;
  frame.matches = matches;
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    frame.matches[i].u += noise_px * noise[i][0];
    frame.matches[i].v += noise_px * noise[i][1];
    frame.matches[i].inv_sigma2 = 1 / (noise_px * noise_px);
  }
  return frame;
}

MetricsScene draw_metrics_scene(const MetricsOptions& options, std::uint64_t run) {
  Draws draws(options.seed, run);
  MetricsScene scene;
  Vector6 xi;
  for (int i = 0; i < 3; ++i) xi[i] = draws.uniform(-translation, translation);
  for (int i = 3; i < 6; ++i) xi[i] = draws.uniform(-rotation_deg, rotation_deg) / degrees;
  scene.true_T_cw = exp_se3(xi);
  for (std::size_t i = 0; i < options.points; ++i) {
    const double z = draws.uniform(nearest, farthest);
    const double x = draws.uniform(-0.8, 0.8) * z, y = draws.uniform(-0.5, 0.5) * z;
    const Eigen::Vector3d point(x, y, z);
    const Eigen::Vector3d mapped =
        point + Eigen::Vector3d::Constant(options.map_bias) + draws.normal3(options.map_deviation);
    const Eigen::Vector3d p_c = scene.true_T_cw * point;
    Match match;
    for (int j = 0; j < 3; ++j) match.point[j] = mapped[j];
    match.u = euroc_camera.fx * p_c.x() / p_c.z() + euroc_camera.cx;
    match.v = euroc_camera.fy * p_c.y() / p_c.z() + euroc_camera.cy;
    scene.matches.push_back(match);
    const double of_u = draws.normal(), of_v = draws.normal();
    scene.noise.push_back({of_u, of_v});
  }
  scene.random_order.resize(options.points);
  std::iota(scene.random_order.begin(), scene.random_order.end(), 0U);
  draws.shuffle_front(scene.random_order, options.points);
  return scene;
}

MetricsRun run_metrics(const MetricsOptions& options, std::uint64_t run) {
  const MetricsScene scene = draw_metrics_scene(options, run);
  MetricsRun errors;
  for (const double noise : options.noises) {
    BlockStore blocks;
    const Frame frame = scene.frame(noise);
    for (const Match& match : frame.matches) append_paper_block(pose_of(frame.T_cw_prior), match, blocks);
    errors.emplace_back();
    for (std::size_t s = 0; s < std::size(metrics_selectors); ++s) {
      const bool is_metric = s < std::size(greedy_metrics);
      const auto order = is_metric ? greedy_order(greedy_metrics[s], blocks) : scene.random_order;
      errors.back().emplace_back();
      for (const std::size_t size : options.sizes) {
        const bool takes_all = s + 1 == std::size(metrics_selectors);
        const std::size_t taken = takes_all ? order.size() : std::min(size, order.size());
        const std::vector<std::uint32_t> subset(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(taken));
        errors.back().back().push_back(error_with(frame, subset, scene.true_T_cw));
      }
    }
  }
  return errors;
}

Table metrics_table(const MetricsOptions& options, const std::vector<MetricsRun>& runs) {
  Table table;
  table.header = {"noise_px", "size", "selector"};
  for (const Part& part : parts)
    table.header.insert(table.header.end(), {part.name, std::string("ci95_of_") + part.name});
  for (std::size_t n = 0; n < options.noises.size(); ++n) {
    for (std::size_t k = 0; k < options.sizes.size(); ++k) {
      for (std::size_t s = 0; s < std::size(metrics_selectors); ++s) {
        table.rows.push_back({exact(options.noises[n]), std::to_string(options.sizes[k]), metrics_selectors[s]});
        for (const Part& part : parts) {
          const Estimate rms = rms_of(runs, n, s, part, {k}).estimate();
          table.rows.back().insert(table.rows.back().end(), {fixed(rms.value, 5), fixed(rms.ci95, 5)});
        }
      }
    }
  }
  return table;
}

Table metrics_means(const MetricsOptions& options, const std::vector<MetricsRun>& runs) {
  std::vector<std::size_t> proper;
  for (std::size_t k = 0; k < options.sizes.size(); ++k) {
    if (options.sizes[k] < options.points) proper.push_back(k);
  }
  Table table;
  table.header = {"selector", "noise_px", "error", "mean_below_all", "ci95", "verdict_of_max_log_det"};
  for (std::size_t s = 0; s < std::size(metrics_selectors); ++s) {
    for (std::size_t n = 0; n < options.noises.size(); ++n) {
      for (const Part& part : parts) {
        const Jackknifed own = rms_of(runs, n, s, part, proper), of_log_det = rms_of(runs, n, 0, part, proper);
        const Estimate mean = own.estimate();
        table.rows.push_back({metrics_selectors[s], exact(options.noises[n]), part.name, fixed(mean.value, 4),
                              fixed(mean.ci95, 4), s == 0 ? "" : verdict(difference(of_log_det, own).estimate())});
      }
    }
  }
  return table;
}

}  // namespace maxlogdet::sim
