// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// How a selection ended. The first three carry an answer; after any other one the selection is empty and its log_det
/// is NaN.
enum class Status {
  ok,                  ///< as many as the budget asks for were selected (none for a budget or a store of 0)
  all_selected,        ///< the budget covers every valid candidate: all of them, be it none, were selected
  deadline_reached,    ///< time_limit passed: what was selected until then, a prefix of the full answer
  invalid_budget,      ///< budget above the selector's capacity
  invalid_epsilon,     ///< stochastic_greedy with epsilon not in (0, 1)
  invalid_prior,       ///< prior not finite, not symmetric, or not safely positive definite (docs/numerics.md)
  capacity_exceeded,   ///< more candidates than the selector's capacity
  invalid_strategy,    ///< strategy not one of the enumerators
  invalid_time_limit,  ///< time_limit negative or NaN
  unsupported_isa,     ///< MAXLOGDET_ISA names an instruction set not built in, or one that this machine lacks
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Status status) noexcept;

/// The answer: views into the Selector that gave it, valid until its next select() or its end.
struct Selection {
  Status status;
  const std::uint32_t* indices;    ///< `size` candidate indices, in order of selection
  std::size_t size;                ///< number selected
  const double* gains;             ///< `size` gains: the growth of log det by each when it was selected, nats
  double log_det;                  ///< log det(prior + sum of selected H^T H), nats
  std::size_t evaluations;         ///< candidate gains computed, in float32; may differ between machines
  std::size_t float64_decisions;   ///< of these, computed again in float64, because float32 could not tell; likewise
  std::size_t invalid_candidates;  ///< candidates without a block (BlockStore::invalid_count): never selected

  /// Whether this is an answer (perhaps cut short by the deadline), not an error.
  bool has_answer() const noexcept {
    return status == Status::ok || status == Status::all_selected || status == Status::deadline_reached;
  }
  const std::uint32_t* begin() const noexcept { return indices; }
  const std::uint32_t* end() const noexcept { return indices + size; }
};

}  // namespace maxlogdet
