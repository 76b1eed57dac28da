// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// How a selection ended. ok, all_selected, deadline_reached and target_reached carry an answer; after any other status
/// the selection is empty and its log_det is NaN.
enum class Status {
  ok,            ///< as many as the budget asks for were selected (none for a budget or a store of 0)
  all_selected,  ///< no more may be selected: every valid candidate that constraints allow, perhaps none, is in (or has
                 ///< been rejected, ActiveSelection)
  deadline_reached,   ///< time_limit passed: the answer so far; for strategies that select one after the other a prefix
                      ///< of the full answer, for others the best so far
  invalid_budget,     ///< budget above the selector's capacity
  invalid_epsilon,    ///< stochastic_greedy with epsilon not in (0, 1)
  invalid_prior,      ///< prior not finite, not symmetric, or not safely positive definite (docs/numerics.md)
  capacity_exceeded,  ///< more candidates than the selector's capacity
  invalid_strategy,   ///< strategy not one of the enumerators
  invalid_time_limit,  ///< time_limit negative or NaN
  invalid_threads,     ///< threads negative
  invalid_groups,      ///< a group not below group_count
  infeasible,  ///< a required candidate is excluded or invalid, or more are required than the budget or the maximum of
               ///< a group allows
  unsupported_groups,  ///< the strategy does not support groups
  nothing_proposed,    ///< ActiveSelection: an answer without a proposal
  invalid_block,       ///< ActiveSelection: the measured block is null, has another number of rows, or is not finite;
                       ///< GoodFeatures, SelectedMatches: there are no blocks
  unsupported_isa,     ///< MAXLOGDET_ISA names an instruction set that is not built in or not supported by this machine
  target_reached,      ///< every target given is met: an answer. Reported also if the budget or the candidates are
                       ///< used up at the same time. With any other status the targets are not met
  invalid_target,      ///< a target negative, NaN or infinite, or target_efficiency above 1
  unsupported_target,  ///< a target with relaxed, backward_greedy or exchange_sweeps, which have no order to stop in
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Status status) noexcept;

/// The answer: views into the Selector that gave it, valid until its next select() or its destruction.
struct Selection {
  Status status;                  ///< how the selection ended
  const std::uint32_t* indices;   ///< `size` candidate indices: required ones, then in order of selection;
                                  ///< backward_greedy's by index; an exchange puts a candidate where it takes one out
  std::size_t size;               ///< number selected
  const double* gains;            ///< `size` gains: the increase in log det when each is added to those before it, nats
  double log_det;                 ///< log det(prior + sum of selected H^T H), nats
  std::size_t evaluations;        ///< gains computed in float32, and losses in float64; may differ between machines
  std::size_t float64_decisions;  ///< of these, computed again in float64, because float32 could not decide; may differ
                                  ///< between machines
  std::size_t invalid_candidates;  ///< candidates without a block (BlockStore::invalid_count): never selected
  double upper_bound;  ///< proved bound, nats: no selection within the budget that respects required and excluded has a
                       ///< greater log det. Maxima of groups are ignored unless the groups are full, and a deadline may
                       ///< end the search or the passes early: both can only raise it. A target does not lower the
                       ///< budget that it is computed for. Infinite where float64 may have no digits left of log det
                       ///< and of what was chosen (docs/numerics.md). NaN if not asked for (Options::certify)
  Strategy strategy;   ///< the requested one, or what `automatic` chose
  int threads;  ///< how many threads the work was offered to, including the calling one, at most 16; helpers may have
                ///< come late or not at all
  double efficiency_of_all;  ///< (det M / det M_all)^(1/6), see Options::target_efficiency; NaN without that target.
                             ///< The last bits of this and the next two may differ between C libraries
  double translation_sigma;  ///< m, see Options::target_translation_sigma; NaN without that target
  double rotation_sigma;     ///< rad, see Options::target_rotation_sigma; NaN without that target

  /// D-efficiency, (det M / det of the bound)^(1/6): the geometric mean of the information over the six directions is
  /// at least this share of that of the best selection. 0 where next to nothing is known. NaN without upper_bound.
  double efficiency() const noexcept { return std::exp((log_det - upper_bound) / state_dimension); }

  /// Returns whether this is an answer (perhaps cut short by the deadline or a target), not an error.
  bool has_answer() const noexcept {
    return status == Status::ok || status == Status::all_selected || status == Status::deadline_reached ||
           status == Status::target_reached;
  }
  /// The first index.
  const std::uint32_t* begin() const noexcept { return indices; }
  /// One past the last index.
  const std::uint32_t* end() const noexcept { return indices + size; }
};

}  // namespace maxlogdet
