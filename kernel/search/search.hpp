// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/information/problem.hpp"
#include "kernel/screening/screening.hpp"
#include "kernel/search/constraints.hpp"
#include "kernel/search/target.hpp"
#include "threading/team.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Memory of the float64 decision of a round.
struct DecisionMemory {
  explicit DecisionMemory(std::size_t capacity);
  std::vector<std::uint32_t> lanes;       ///< of the survivors
  std::vector<std::uint32_t> candidates;  ///< in these lanes
  std::vector<double> relative_gains;     ///< of these candidates
  std::vector<std::uint32_t> order;       ///< positions in the above, best first
};

/// All the memory of a Search among up to `capacity` candidates, allocated once. Throws std::bad_alloc for a capacity
/// that does not fit into 32 bits.
struct SearchMemory {
  explicit SearchMemory(std::size_t capacity);

  std::size_t capacity;
  const simd::Kernel* kernel;  ///< picked on construction; nullptr: MAXLOGDET_ISA names an unsupported one
  threading::Team team;
  CandidatesMemory candidates;
  ScreeningMemory screening;
  ConstraintsMemory constraints;
  DecisionMemory decisions;
  std::vector<unsigned char> is_counted;  ///< per candidate: whether it is part of M_all of a target
  std::vector<std::uint32_t> selected;    ///< the answer, in order of selection
  std::vector<std::uint32_t> reported;    ///< the same in the caller's indices
  std::vector<double> gains;              ///< of the answer, nats
};

/// The state that every strategy works on: the remaining candidates, the information and the answer so far. All memory
/// belongs to the SearchMemory.
struct Search {
  /// `memory` must have a kernel, and room for the candidates.
  Search(const BlockStore& blocks, const Options& options, SearchMemory& memory) noexcept;

  /// Reads constraints, prior and targets, and selects the required candidates. Returns the first error.
  Error start(const BlockStore& blocks, const Options& options) noexcept;

  SearchMemory& memory;
  Candidates candidates;
  const simd::Kernel& kernel;
  Evaluator evaluator;
  Screening screening;
  Constraints constraints;
  const double* prior_matrix = nullptr;  ///< as in Options
  InformationFactor prior;
  InformationFactor factor;  ///< of the prior and the answer so far
  Deadline deadline;
  Target target;
  bool is_enough = false;             ///< whether the targets are met
  std::size_t budget;                 ///< how many to select, including required candidates
  bool has_candidates;                ///< whether the store has any, valid or not
  std::size_t remaining = 0;          ///< candidates that may still be selected
  std::size_t selected = 0;           ///< entries of the answer so far
  std::size_t filled = 0;             ///< of these, how many the deadline kept the search from selecting
  std::size_t float64_decisions = 0;  ///< survivors evaluated in float64
  std::size_t unscreened = 0;         ///< gains and losses that float64 alone evaluated
  std::uint32_t* indices;             ///< the answer, in order of selection
  double* gains;                      ///< its gains, nats

  bool wants_more() const noexcept { return selected < budget && remaining > 0 && !is_enough; }

  /// The lane of the best candidate that this round has evaluated, by `factor`, which screening.begin_round() must have
  /// been given. Float64 decides between the survivors; ties go to the lowest index. screening.lanes() if there is
  /// none.
  std::size_t find_best() noexcept;

  /// The same for the k best, in descending order, and for further ones that are certain without another evaluation.
  /// Returns how many; fewer than k only if no more remain.
  std::size_t find_best(std::size_t k, std::uint32_t* best) noexcept;

  /// sum, 6 x 6: H^T H over the candidates i with counted[i] != 0, in a tenth of the time of adding their rows; but
  /// this squares the condition number. Returns its roundings for InformationFactor::reset.
  double sum_up(const unsigned char* counted, double* sum) const noexcept;

  /// Adds a candidate's rows to the information only; returns the relative gain.
  double add_rows(std::uint32_t candidate) noexcept { return add_rows(candidate, factor); }

  /// The same for another information.
  double add_rows(std::uint32_t candidate, InformationFactor& to) const noexcept;

  /// Downdates the information by a candidate's rows; as InformationFactor::remove_block.
  bool remove_rows(std::uint32_t candidate) noexcept;

  /// Adds a candidate to the answer and its rows to the information; remove() then keeps it from being found again.
  void add(std::uint32_t candidate) noexcept { append(candidate, add_rows(candidate)); }

  /// The same with `count` other rows instead of its own.
  void add(std::uint32_t candidate, const double (*rows)[state_dimension], int count) noexcept;

  /// Removes an added candidate from the screening, and the rest of its group if that is full now (and the screening
  /// holds all remaining candidates).
  void remove(std::size_t lane) noexcept;

  /// Removes a candidate that was not added, between rounds or within one.
  void reject(std::size_t lane, bool is_round_open) noexcept;

  /// Adds the candidate of this lane, of find_best() or any other that remains, and removes it. Keeps groups, targets
  /// and `remaining` right.
  void select(std::size_t lane) noexcept;

  /// Finds, adds and removes the best candidate. Returns its lane.
  std::size_t select_best() noexcept;

  /// The problem, for functions that need no state of the search.
  Problem problem() const noexcept;

  /// Fills in the answer; `status`: how the search ended.
  void report(Status status, Selection& selection) const noexcept;

 private:
  void append(std::uint32_t candidate, double relative_gain) noexcept;
  void discard(std::size_t lane) noexcept;
  void set_target(const Options& options) noexcept;
  InformationFactor factor_of_all(const unsigned char* counted) const noexcept;
};

}  // namespace maxlogdet
