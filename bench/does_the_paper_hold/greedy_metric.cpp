// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/greedy_metric.hpp"

#include "bench/does_the_paper_hold/block_information.hpp"
#include "bench/does_the_paper_hold/eigenvalue_search.hpp"
#include "bench/does_the_paper_hold/eigenvalues.hpp"

#include <maxlogdet/eigen.hpp>
#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <stdexcept>

namespace maxlogdet::sim {
namespace {

// Returns the smallest eigenvalue with which Q reaches `best`. To improve a condition number, lambda_min must be above
// lambda_max / condition, and lambda_max is at least v^T Q v, v the last round's eigenvector of the largest eigenvalue.
double needed_eigenvalue(GreedyMetric metric, const Matrix6& Q, double best, const Vector6& v) {
  if (metric == GreedyMetric::max_min_eigenvalue) return best;
  return v.dot(Q * v) / -best;
}

std::vector<std::uint32_t> select_by_eigenvalues(GreedyMetric metric, const std::vector<Matrix6>& information,
                                                 std::vector<std::uint32_t> remaining, std::size_t k, Matrix6 Q) {
  std::vector<std::uint32_t> selected;
  while (selected.size() < k) {
    const Vector6 v = largest_eigenvector(Q);
    const std::size_t winner = best_by_eigenvalues(
        remaining.size(), Q, [&](std::size_t r) -> const Matrix6& { return information[remaining[r]]; },
        [&](const Matrix6& with_it) { return value_of(metric, with_it); },
        [&](const Matrix6& with_it, double best) { return needed_eigenvalue(metric, with_it, best, v); },
        [&](double best, double slack) {
          return metric == GreedyMetric::max_min_eigenvalue ? slack : eigenvalue_rounding * best * best;
        });
    selected.push_back(remaining[winner]);
    Q += information[remaining[winner]];
    remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(winner));
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

std::vector<std::uint32_t> select_by_log_det(const BlockStore& blocks, std::size_t k, const Matrix6& prior) {
  const EigenPrior rows(prior);
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

double value_of(GreedyMetric metric, const Matrix6& Q) {
  if (metric == GreedyMetric::max_trace) return Q.trace();
  const Vector6 eigenvalues = eigenvalues_of(Q);
  if (metric == GreedyMetric::min_condition) return -eigenvalues[5] / eigenvalues[0];
  if (metric == GreedyMetric::max_min_eigenvalue) return eigenvalues[0];
  return eigenvalues.array().log().sum();
}

std::vector<std::uint32_t> select_greedily(GreedyMetric metric, const BlockStore& blocks, std::size_t k,
                                           const Matrix6& prior) {
  std::vector<Matrix6> information(blocks.size(), Matrix6::Zero());
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (!blocks.is_valid(i)) continue;
    information[i] = information_of(blocks, i);
    candidates.push_back(i);
  }
  k = std::min(k, candidates.size());
  if (metric == GreedyMetric::max_log_det) return select_by_log_det(blocks, k, prior);
  if (metric == GreedyMetric::max_trace) return select_by_trace(information, std::move(candidates), k);
  return select_by_eigenvalues(metric, information, std::move(candidates), k, prior);
}

}  // namespace maxlogdet::sim
