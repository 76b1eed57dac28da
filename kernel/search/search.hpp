// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/information/problem.hpp"
#include "kernel/screening/screening.hpp"
#include "kernel/search/answer.hpp"
#include "kernel/search/constraints.hpp"
#include "kernel/search/target.hpp"
#include "threading/team.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// All the memory of a Search among up to `capacity` candidates, allocated once. Throws std::bad_alloc for a capacity
/// that does not fit into 32 bits.
struct SearchMemory {
  explicit SearchMemory(std::size_t capacity);

  std::size_t capacity;
  const simd::Kernel* kernel;  ///< picked on construction; nullptr: MAXLOGDET_ISA names an unsupported one
  threading::Team team;
  CandidatesMemory candidates;
  ScreeningMemory screening;
  Constraints constraints;
  Answer answer;
  std::vector<Lane> survivors;            ///< of a round, between which float64 decides
  std::vector<Candidate> surviving;       ///< in these lanes
  std::vector<double> relative_gains;     ///< of these candidates
  std::vector<std::uint32_t> order;       ///< positions in the three above, best first
  std::vector<unsigned char> is_counted;  ///< per candidate: whether it is part of M_all of a target
  std::vector<std::uint32_t> reported;    ///< the answer in the caller's indices
};

/// What every strategy works on: the candidates that remain, and the answer so far. All memory belongs to the
/// SearchMemory. Strategies change the answer only by what is here, so that groups, targets, the count of what remains
/// and the bounds of the screening follow.
class Search {
 public:
  /// `memory` must have a kernel, and room for the candidates. `deadline`: since the caller began.
  Search(const BlockStore& blocks, const Options& options, const Deadline& deadline, SearchMemory& memory) noexcept;

  /// Reads constraints, prior and targets, and selects the required candidates. Returns the first error.
  Error start(const BlockStore& blocks, const Options& options) noexcept;

  /// The candidates, the prior and the constraints, for functions that need no state of the search.
  const Problem& problem() const noexcept { return problem_; }
  const Answer& answer() const noexcept { return answer_; }
  Constraints& constraints() noexcept { return constraints_; }
  Screening& screening() noexcept { return screening_; }

  /// Whether the budget has room, candidates remain, and the targets are not met.
  bool wants_more() const noexcept { return missing() > 0 && !is_enough_; }
  bool is_late() const noexcept { return deadline_.has_passed(); }
  /// Candidates that may still be selected, and how many of them the budget allows.
  std::size_t remaining() const noexcept { return remaining_; }
  std::size_t missing() const noexcept { return std::min(budget_ - answer_.size(), remaining_); }

  /// The lane of the best candidate in an open round of the screening at the information of the answer, no_lane if
  /// there is none. Float64 decides between the survivors; ties go to the lowest index.
  Lane find_best() noexcept;

  /// The same for the k best, in descending order, and for further ones that are certain without another evaluation.
  /// Returns how many; fewer than k only if no more remain.
  std::size_t find_best(std::size_t k, Lane* best) noexcept;

  /// The same in a round of its own at another information, among the tiles with a stale bound of at least `min_bound`.
  Lane find_best_at(const InformationFactor& factor, float min_bound) noexcept;

  /// Adds the candidate of a lane to the answer and removes it from what remains, and the rest of its group if that is
  /// full now. `rows`: `count` others instead of its own.
  void select(Lane lane, const double (*rows)[state_dimension] = nullptr, int count = 0) noexcept;
  /// The same for a candidate that the screening need not hold; what is full is left to the caller, who tells
  /// close().
  void add(Candidate candidate) noexcept;

  /// Removes a candidate that was not selected.
  void reject(Lane lane) noexcept;
  /// Counts candidates that are out without being in a lane.
  void close(std::size_t count) noexcept { remaining_ -= count; }

  /// Starts again with the required candidates, and adds these, none of which is required; with groups, as many as were
  /// selected, and their rooms are settled by the caller. The screening needs its candidates again.
  void restart_with(const Candidate* candidates, std::size_t count) noexcept;

  /// Counts work of float64 alone, in gains or losses.
  void count_evaluations(std::size_t count) noexcept { unscreened_ += count; }

  /// Fills in the answer; `status`: how the search ended.
  void report(Status status, Selection& selection) const noexcept;

 private:
  Lane decide(const InformationFactor& factor, std::size_t survivors) noexcept;
  void evaluate_survivors(const InformationFactor& factor, std::size_t count) noexcept;
  void take(Candidate candidate) noexcept;
  void set_target(const Options& options) noexcept;
  InformationFactor factor_of_all(const unsigned char* counted) const noexcept;
  void check_target() noexcept { is_enough_ = target_.is_asked() && target_.is_met(answer_.factor()); }

  SearchMemory& memory_;
  Candidates candidates_;
  Evaluator evaluator_;
  Screening screening_;
  Problem problem_;
  Constraints& constraints_;
  Answer& answer_;
  Deadline deadline_;
  Target target_;
  bool is_enough_ = false;
  std::size_t budget_;          // including required candidates
  bool has_candidates_;         // whether the store has any, valid or not
  std::size_t remaining_ = 0;   // candidates that may still be selected
  std::size_t decisions_ = 0;   // survivors evaluated in float64
  std::size_t unscreened_ = 0;  // gains and losses that float64 alone evaluated
};

/// Marks the free candidates that are not selected.
void mark_unselected(const Search& search, ArrayOf<Candidate, unsigned char>& flags) noexcept;

}  // namespace maxlogdet
