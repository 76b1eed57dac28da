// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/aligned_array.hpp"
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/screening/losses.hpp"
#include "kernel/screening/screening.hpp"
#include "kernel/search/constraints.hpp"
#include "kernel/search/deadline.hpp"
#include "kernel/search/target.hpp"
#include "threading/team.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// All the memory of a Search among up to `most` candidates; made once, it grows no more.
struct SearchMemory {
  explicit SearchMemory(std::size_t most);

  std::size_t capacity;
  const simd::Kernel* kernel;  ///< picked when this is made; nullptr: MAXLOGDET_ISA names one that is not there
  threading::Team team;
  CandidatesMemory candidates;
  ScreeningMemory screening;
  LossesMemory losses;
  ConstraintsMemory constraints;
  std::vector<double> relative_gains;
  std::vector<std::uint32_t> lanes;
  std::vector<std::uint32_t> contenders;
  std::vector<std::uint32_t> pool;
  std::vector<std::uint32_t> draws;
  std::vector<unsigned char> unselected;
  std::vector<unsigned char> open;
  std::vector<std::uint32_t> selected;
  std::vector<std::uint32_t> indices;
  std::vector<double> gains;
  AlignedArray<float> traces;
};

/// What every strategy works on: the candidates that remain, the information gathered so far, and the answer as it
/// grows. All arrays belong to the SearchMemory and have room for as many entries as it has capacity.
struct Search {
  /// `memory` has a kernel, and room for the candidates.
  Search(const BlockStore& blocks, const Options& options, SearchMemory& memory) noexcept;

  /// Takes over constraints and prior, and selects what is required; the first thing wrong with them, or ok.
  Status start(const BlockStore& blocks, const Options& options) noexcept;

  Candidates candidates;
  const simd::Kernel& kernel;
  threading::Evaluator evaluator;
  ScreeningMemory& screening_memory;  ///< of the screening, for a strategy that has no use for one
  LossesMemory& losses;
  Screening screening;
  Constraints constraints;
  const double* prior_matrix = nullptr;  ///< as in Options
  InformationFactor prior;
  InformationFactor factor;
  Deadline deadline;
  Target target;
  bool is_enough = false;             ///< the targets are met
  std::size_t budget;                 ///< how many to select, those required included
  bool has_candidates;                ///< the store does, be they invalid
  std::size_t remaining = 0;          ///< candidates that may be selected and are not yet
  std::size_t selected = 0;           ///< entries of the answer so far
  std::size_t float64_decisions = 0;  ///< candidates that float64 had to tell apart
  std::size_t losses_evaluated = 0;   ///< by backward_greedy
  double* relative_gains;             ///< scratch
  std::uint32_t* lanes;               ///< scratch
  std::uint32_t* contenders;          ///< scratch
  std::uint32_t* pool;                ///< scratch of a strategy
  std::uint32_t* draws;               ///< scratch of a strategy
  unsigned char* unselected;          ///< scratch, per candidate
  unsigned char* open;                ///< scratch, per candidate
  std::uint32_t* indices;             ///< the answer, in order of selection
  std::uint32_t* reported;            ///< the same in the caller's indices
  double* gains;                      ///< its gains, nats
  float* traces;                      ///< scratch, whole tiles

  bool wants_more() const noexcept { return selected < budget && remaining > 0 && !is_enough; }

  /// The lane of the best of the candidates that this round has evaluated. Float64 decides between those
  /// that float32 cannot tell apart; ties go to the lowest index. screening.lanes() if there is none.
  std::size_t find_best() noexcept;

  /// The same for the `wanted` best, in descending order, and for as many more as are known without further evaluation.
  /// Returns how many; fewer than wanted only where no more remain.
  std::size_t find_best(std::size_t wanted, std::uint32_t* best) noexcept;

  /// sum, 6 x 6: H^T H over the candidates i with counted[i] != 0, all at once, a tenth of the time of adding them one
  /// by one; but that squares the condition number. Returns its roundings, as InformationFactor::reset takes them.
  double sum_up(const unsigned char* counted, double* sum) const noexcept;

  /// Adds a candidate's rows to the information alone; returns the relative relative gain of its determinant.
  double add_rows(std::uint32_t candidate) noexcept;

  /// The same to another information.
  double add_rows(std::uint32_t candidate, InformationFactor& to) const noexcept;

  /// Takes them out again; as InformationFactor::remove_block.
  bool remove_rows(std::uint32_t candidate) noexcept;

  /// Adds a candidate to the answer and its rows to the information; take_out() then keeps it from being found again.
  void add(std::uint32_t candidate) noexcept;

  /// The same with other rows, `count` of them, in its place.
  void add(std::uint32_t candidate, const double (*rows)[state_dimension], int count) noexcept;

  /// Takes out a candidate that was added, with the rest of its group if that is full now (where the screening holds
  /// all that remains).
  void take_out(std::size_t lane) noexcept;

  /// Takes out a candidate that was not.
  void discard(std::size_t lane) noexcept;

  /// The same, perhaps within a round.
  void reject(std::size_t lane, bool is_round_open) noexcept;

  /// Adds what find_best has found, and takes it out.
  void select(std::size_t lane) noexcept;

  /// Finds it, too. Returns its lane.
  std::size_t select_best() noexcept;

  /// Fills in what was selected; `status`: how the search ended.
  void report(Status status, Selection& selection) const noexcept;

 private:
  void append(std::uint32_t candidate, double relative_gain) noexcept;
  void set_target(const Options& options) noexcept;
  InformationFactor factor_of_all(const unsigned char* counted) const noexcept;
};

/// The first thing wrong with what the caller asks for; ok if nothing is.
Status check(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept;

/// A selection of nothing, as it is after an error.
Selection empty_selection(Status status) noexcept;

/// Greedy's answer for less: gains only ever shrink (submodularity), so a candidate whose last known gain is below the
/// best found this round need not be evaluated again (Minoux 1978), here by tiles of candidates.
Status lazy_greedy(Search& search) noexcept;

/// The same among what the screening holds, in the order of the store or as listed.
Status search_lazily(Search& search) noexcept;

/// Starts from all candidates and removes the one of least loss, -log det(I - Y Y^T), until the budget is left; the
/// highest index on ties. They are listed by index. `lazily`: without evaluating those that cannot be the least; the
/// same answer. At the deadline those of largest loss by then are kept.
Status backward_greedy(Search& search, bool lazily = true) noexcept;

/// At most so many sweeps over the answer, in each of which every candidate that is not required is put to the test: it
/// makes way for the best of those that are not selected if that gains more in its place (Fedorov 1972). log det never
/// falls. At the deadline the answer is what it is by then.
Status exchange(Search& search, std::size_t sweeps) noexcept;

}  // namespace maxlogdet
