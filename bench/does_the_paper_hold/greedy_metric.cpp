// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/greedy_metric.hpp"

#include "bench/world/se3.hpp"

#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <stdexcept>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Bounds the error of an eigenvalue of Q, relative to its trace; the solver's is about 1e-15.
constexpr double eigenvalue_rounding = 1e-13;

constexpr double prior = 1e-5;  // times I

Matrix6 information_of(const BlockStore& blocks, std::size_t i) {
  double entries[max_block_rows * state_dimension];
  const int rows = blocks.block(i, entries);
  Matrix6 information = Matrix6::Zero();
  for (int row = 0; row < rows; ++row) {
    const Vector6 h(entries + state_dimension * row);
    information += h * h.transpose();
  }
  return information;
}

// Greater is better.
double value_of(GreedyMetric metric, const Matrix6& Q) {
  const Vector6 eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix6>(Q, Eigen::EigenvaluesOnly).eigenvalues();
  return metric == GreedyMetric::max_min_eigenvalue ? eigenvalues[0] : -eigenvalues[5] / eigenvalues[0];
}

std::vector<std::uint32_t> select_by_eigenvalues(GreedyMetric metric, const std::vector<Matrix6>& information,
                                                 std::vector<std::uint32_t> remaining, std::size_t k) {
  std::vector<std::uint32_t> selected;
  Matrix6 Q = prior * Matrix6::Identity();
  while (selected.size() < k) {
    auto winner = remaining.begin();
    double best = value_of(metric, Q + information[*winner]);
    for (auto candidate = winner + 1; candidate != remaining.end(); ++candidate) {
      const Matrix6 with_it = Q + information[*candidate];
      const double value = value_of(metric, with_it);
      const double scale = metric == GreedyMetric::max_min_eigenvalue ? with_it.trace() : best * best;
      if (!(value > best + eigenvalue_rounding * scale)) continue;
      winner = candidate;
      best = value;
    }
    selected.push_back(*winner);
    Q += information[*winner];
    remaining.erase(winner);
  }
  return selected;
}

std::vector<std::uint32_t> select_by_trace(const std::vector<Matrix6>& information,
                                           std::vector<std::uint32_t> candidates, std::size_t k) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return information[a].trace() > information[b].trace(); });
  candidates.resize(k);
  return candidates;
}

std::vector<std::uint32_t> select_by_log_det(const BlockStore& blocks, std::size_t k) {
  const EigenPrior rows(Matrix6(prior * Matrix6::Identity()));
  Options options;
  options.budget = k;
  options.prior = rows.data();
  Selector selector(blocks.size());
  const Selection selection = selector.select(blocks, options);
  if (!selection.has_answer()) throw std::invalid_argument(to_string(selection.status));
  return {selection.begin(), selection.end()};
}

}  // namespace

const char* to_string(GreedyMetric metric) {
  switch (metric) {
    case GreedyMetric::max_log_det: return "max_log_det";
    case GreedyMetric::max_trace: return "max_trace";
    case GreedyMetric::min_condition: return "min_condition";
    case GreedyMetric::max_min_eigenvalue: return "max_min_eigenvalue";
  }
  return "unknown";
}

std::vector<std::uint32_t> select_greedily(GreedyMetric metric, const BlockStore& blocks, std::size_t k) {
  std::vector<Matrix6> information(blocks.size(), Matrix6::Zero());
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (!blocks.is_valid(i)) continue;
    information[i] = information_of(blocks, i);
    candidates.push_back(i);
  }
  k = std::min(k, candidates.size());
  if (metric == GreedyMetric::max_log_det) return select_by_log_det(blocks, k);
  if (metric == GreedyMetric::max_trace) return select_by_trace(information, std::move(candidates), k);
  return select_by_eigenvalues(metric, information, std::move(candidates), k);
}

}  // namespace maxlogdet::sim
