// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// Table I of the paper: metrics that select a subset of rows, Q = 1e-5 I + sum of selected H^T H.
enum class GreedyMetric {
  max_log_det,         ///< log det Q, by this library
  max_trace,           ///< tr Q: modular, so that sorting by tr H^T H is exact
  min_condition,       ///< lambda_max(Q) / lambda_min(Q)
  max_min_eigenvalue,  ///< lambda_min(Q)
};

constexpr GreedyMetric greedy_metrics[] = {GreedyMetric::max_log_det, GreedyMetric::max_trace,
                                           GreedyMetric::min_condition, GreedyMetric::max_min_eigenvalue};

const char* to_string(GreedyMetric metric);

/// Returns the first `k` (at most all valid) candidates in greedy's order: its first j are the greedy selection of j.
/// Ties go to the lowest index, and values that differ by less than rounding are ties: the smallest eigenvalue is only
/// rounding while Q lacks a direction.
std::vector<std::uint32_t> select_greedily(GreedyMetric metric, const BlockStore& blocks, std::size_t k);

}  // namespace maxlogdet::sim
