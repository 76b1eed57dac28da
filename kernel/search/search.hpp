// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/information/prior.hpp"
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
  PriorMemory prior;
  ScreeningMemory screening;
  Constraints constraints;
  Answer answer;
  std::vector<Lane> survivors;            ///< of a round, between which float64 decides
  std::vector<Candidate> deciding;        ///< the survivors' candidates
  std::vector<Candidate> pool;            ///< scratch of a strategy
  std::vector<double> relative_gains;     ///< of the survivors; traces of all candidates
  std::vector<std::uint32_t> order;       ///< numbers of candidates
  std::vector<unsigned char> is_counted;  ///< per candidate: whether it is part of a sum
  std::vector<std::uint32_t> reported;    ///< the answer in the caller's indices
};

/// What every strategy works on: the candidates that remain, and the answer so far. All memory belongs to the
/// SearchMemory. Strategies change the answer only by what is here, so that groups, targets and the count of what
/// remains follow.
class Search {
 public:
  /// `memory` must have a kernel, and room for the candidates. `deadline`: since the caller began.
  Search(const BlockStore& blocks, const Options& options, const Deadline& deadline, SearchMemory& memory) noexcept;

  /// Reads constraints, prior and targets, and selects the required candidates. Returns the first error.
  Error start(const BlockStore& blocks, const Options& options) noexcept;

  /// The candidates, the prior and the constraints, for functions that need no state of the search.
  const Problem& problem() const noexcept { return problem_; }
  const Answer& answer() const noexcept { return answer_; }
  const Constraints& constraints() const noexcept { return constraints_; }
  Screening& screening() noexcept { return screening_; }
  /// Scratch of a strategy, for all candidates.
  Candidate* pool() noexcept { return memory_.pool.data(); }

  /// Whether the budget has room, candidates remain, and the targets are not met.
  bool wants_more() const noexcept { return missing() > 0 && !is_enough_; }
  bool is_late() const noexcept { return deadline_.has_passed(); }
  /// Candidates that may still be selected, and how many of them the budget allows.
  std::size_t remaining() const noexcept { return remaining_; }
  std::size_t missing() const noexcept { return std::min(budget_ - answer_.size(), remaining_); }

  /// The lane of the best candidate in an open round of the screening at the information of the answer. Float64 decides
  /// between the survivors; ties go to the lowest index.
  Lane find_best() noexcept;

  /// Adds the candidate of a lane to the answer and removes it from what remains, and the rest of its group if that is
  /// full now.
  void select(Lane lane) noexcept;
  /// Lists the candidates that remain, for a search that goes on among these.
  std::size_t list_remaining(Candidate* list) noexcept;
  /// Counts candidates that are out without being in a lane.
  void close(std::size_t count) noexcept { remaining_ -= count; }

  /// A proved upper bound of the log det of any selection that the options allow, nats; infinite where log det may have
  /// no correct digits.
  double upper_bound() noexcept;

  /// Fills in the answer; `status`: how the search ended.
  void report(Status status, Selection& selection) const noexcept;

 private:
  void take(Candidate candidate) noexcept;
  void reject(Lane lane) noexcept;
  void set_target() noexcept;
  InformationFactor factor_of_all() noexcept;
  void check_target() noexcept { is_enough_ = target_.is_asked() && target_.is_met(answer_.factor()); }
  double log_det() const noexcept;

  SearchMemory& memory_;
  Candidates candidates_;
  Screening screening_;
  Prior prior_;
  Problem problem_;
  Constraints& constraints_;
  Answer& answer_;
  Deadline deadline_;
  Target target_;
  bool is_enough_ = false;
  std::size_t budget_;         // including required candidates
  bool has_candidates_;        // whether the store has any, valid or not
  std::size_t remaining_ = 0;  // candidates that may still be selected
  std::size_t decisions_ = 0;  // survivors evaluated in float64
};

}  // namespace maxlogdet
