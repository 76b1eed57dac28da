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

/// What float64 decides between, in a round.
struct DecisionMemory {
  explicit DecisionMemory(std::size_t capacity);
  std::vector<std::uint32_t> lanes;       ///< of the survivors
  std::vector<std::uint32_t> candidates;  ///< in these lanes
  std::vector<double> relative_gains;     ///< of each of them
  std::vector<std::uint32_t> order;       ///< positions above, the best first
};

/// All the memory of a Search among up to `capacity` candidates, allocated once. Throws std::bad_alloc for a capacity
/// that does not fit into 32 bits.
struct SearchMemory {
  explicit SearchMemory(std::size_t capacity);

  std::size_t capacity;
  const simd::Kernel* kernel;  ///< picked when this is made; nullptr: MAXLOGDET_ISA names one that is not there
  threading::Team team;
  CandidatesMemory candidates;
  ScreeningMemory screening;
  ConstraintsMemory constraints;
  DecisionMemory decisions;
  std::vector<unsigned char> is_counted;  ///< per candidate: whether a target compares with its information
  std::vector<std::uint32_t> selected;    ///< the answer, in order of selection
  std::vector<std::uint32_t> reported;    ///< the same in the caller's indices
  std::vector<double> gains;              ///< of the answer, nats
};

/// What every strategy works on: the candidates that remain, the information gathered so far, and the answer as it
/// grows. All memory belongs to the SearchMemory.
struct Search {
  /// `memory` has a kernel, and room for the candidates.
  Search(const BlockStore& blocks, const Options& options, SearchMemory& memory) noexcept;

  /// Takes over constraints and prior, and selects what is required; the first thing wrong with them, or ok.
  Status start(const BlockStore& blocks, const Options& options) noexcept;

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
  bool is_enough = false;             ///< the targets are met
  std::size_t budget;                 ///< how many to select, those required included
  bool has_candidates;                ///< the store does, even if none is valid
  std::size_t remaining = 0;          ///< candidates that may be selected and are not yet
  std::size_t selected = 0;           ///< entries of the answer so far
  std::size_t float64_decisions = 0;  ///< candidates that float64 had to decide between
  std::size_t losses_evaluated = 0;   ///< by backward elimination
  std::uint32_t* indices;             ///< the answer, in order of selection
  double* gains;                      ///< its gains, nats

  bool wants_more() const noexcept { return selected < budget && remaining > 0 && !is_enough; }

  /// The lane of the best of the candidates that this round has evaluated. Float64 decides between those that float32
  /// cannot tell apart; ties go to the lowest index. screening.lanes() if there is none.
  std::size_t find_best() noexcept;

  /// The same for the `wanted` best, in descending order, and for as many more as are known without further evaluation.
  /// Returns how many; fewer than wanted only where no more remain.
  std::size_t find_best(std::size_t wanted, std::uint32_t* best) noexcept;

  /// sum, 6 x 6: H^T H over the candidates i with counted[i] != 0, in a tenth of the time of adding them one by one;
  /// but this squares the condition number. Returns its roundings, as InformationFactor::reset takes them.
  double sum_up(const unsigned char* counted, double* sum) const noexcept;

  /// Adds a candidate's rows to the information alone; returns the relative gain.
  double add_rows(std::uint32_t candidate) noexcept { return add_rows(candidate, factor); }

  /// The same to another information.
  double add_rows(std::uint32_t candidate, InformationFactor& to) const noexcept;

  /// Downdates the information by a candidate's rows; as InformationFactor::remove_block.
  bool remove_rows(std::uint32_t candidate) noexcept;

  /// Adds a candidate to the answer and its rows to the information; take_out() then keeps it from being found again.
  void add(std::uint32_t candidate) noexcept { append(candidate, add_rows(candidate)); }

  /// The same with other rows, `count` of them, in its place.
  void add(std::uint32_t candidate, const double (*rows)[state_dimension], int count) noexcept;

  /// Takes out a candidate that was added, with the rest of its group if that is full now (where the screening holds
  /// all that remains).
  void take_out(std::size_t lane) noexcept;

  /// Takes out a candidate that was not added, between rounds or within one.
  void reject(std::size_t lane, bool is_round_open) noexcept;

  /// Adds what find_best() has found, and takes it out.
  void select(std::size_t lane) noexcept;

  /// Finds the best candidate, adds it, and takes it out. Returns its lane.
  std::size_t select_best() noexcept;

  /// What is asked, for parts that need no search.
  Problem problem() const noexcept;

  /// Fills in what was selected; `status`: how the search ended.
  void report(Status status, Selection& selection) const noexcept;

 private:
  void append(std::uint32_t candidate, double relative_gain) noexcept;
  void discard(std::size_t lane) noexcept;
  void set_target(const Options& options) noexcept;
  InformationFactor factor_of_all(const unsigned char* counted) const noexcept;
};

}  // namespace maxlogdet
