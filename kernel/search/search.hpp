// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/factor.hpp"
#include "kernel/information/prior.hpp"
#include "kernel/screening/screening.hpp"
#include "kernel/search/constraints.hpp"
#include "threading/team.hpp"

#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// What every strategy works on: the candidates that remain, the answer so far, and its information; in memory that is
/// allocated once. Strategies change the answer only by what is here, so that groups, target and the count of what
/// remains follow.
class Search {
 public:
  /// Throws std::bad_alloc, also for a capacity that does not fit into 32 bits.
  explicit Search(std::size_t capacity);

  std::size_t capacity() const noexcept { return indices_.size(); }
  /// Picked on construction; nullptr: MAXLOGDET_ISA names one that is not supported.
  const simd::Kernel* kernel() const noexcept { return kernel_; }
  threading::Team& team() noexcept { return team_; }

  /// Begins a selection: reads constraints, prior and target, and selects the required candidates. Returns the first
  /// error. There is a kernel, and the capacity suffices. `deadline`: since the caller began.
  Error start(const Candidates& candidates, const Options& options, const Deadline& deadline) noexcept;

  /// Whether the budget has room, candidates remain, and no target is met.
  bool wants_more() const noexcept { return missing() > 0 && !meets_target(); }
  bool is_late() const noexcept { return deadline_.has_passed(); }
  /// Candidates that may still be selected, and how many of them the budget allows.
  std::size_t remaining() const noexcept { return remaining_; }
  std::size_t missing() const noexcept { return std::min(budget_ - size_, remaining_); }
  /// How many are selected, and of how many rows their blocks are.
  std::size_t size() const noexcept { return size_; }
  int rows() const noexcept { return candidates_.rows; }

  /// What remains is screened from here on: in the order of the store; or these alone, gathered.
  void screen_all() noexcept { screening_.use_store(constraints_.free()); }
  void screen(const Index* listed, std::size_t count) noexcept { screening_.use_listed(listed, count); }
  /// After a round that has evaluated all, orders it by the gains: later rounds evaluate little.
  void order_by_gain() noexcept { screening_.order_by_gain(); }
  bool is_ordered() const noexcept { return screening_.layout().is_ordered(); }

  /// A round: the lane of the best of what is screened. Float64 decides between the survivors of the screening; ties go
  /// to the lowest index.
  Lane find_best() noexcept;
  Index candidate(Lane lane) const noexcept { return screening_.layout().candidate(lane); }
  /// Adds the candidate of a lane to the answer and removes it from what remains, and the rest of its group if that is
  /// full now.
  void select(Lane lane) noexcept;

  /// Lists all that remain, remaining() of them, for a strategy to draw from; to be changed at will. Prepares screen().
  Index* list_remaining() noexcept;
  /// Drops from the first remaining() of that list those whose group is full.
  void drop_closed(Index* list) noexcept;
  /// Whether the group of this candidate has room left.
  bool has_room(Index candidate) const noexcept { return constraints_.has_room(candidate); }

  /// A proved upper bound of the log det of any selection that the options allow, nats; infinite where log det may have
  /// no correct digits.
  double upper_bound() noexcept;

  /// Fills in the answer; `status`: how the search ended.
  void report(Status status, Selection& selection) const noexcept;

 private:
  double add_rows(Index candidate, InformationFactor& to) const noexcept;
  void take(Index candidate) noexcept;
  void reject(Lane lane) noexcept;
  void compare_with_all() noexcept;
  double against_all(int c) const noexcept;
  bool meets_target() const noexcept;
  double efficiency() const noexcept;
  double log_det() const noexcept;
  double bound_of_traces(std::size_t budget) noexcept;
  std::size_t list_by_trace(std::size_t count) noexcept;

  const simd::Kernel* kernel_;
  threading::Team team_;
  Candidates candidates_;
  Prior prior_;
  Constraints constraints_;
  Screening screening_;
  Deadline deadline_;
  std::size_t budget_ = 0;     // including required candidates
  std::size_t remaining_ = 0;  // candidates that may still be selected
  std::size_t decisions_ = 0;  // survivors evaluated in float64

  // The answer, in order of selection.
  std::size_t size_ = 0;
  std::vector<std::uint32_t> indices_;
  std::vector<double> gains_;  // the increase in log det when each is added to those before it, nats
  InformationFactor at_prior_, factor_;

  double target_efficiency_ = 0;                  // 0: none
  double diagonal_of_all_[state_dimension] = {};  // of the Cholesky factor L of M_all, which the target compares with

  AlignedArray<float> sizes_;            // of blocks, to find a typical one
  std::vector<Lane> survivors_;          // of a round, between which float64 decides
  std::vector<Index> deciding_;          // their candidates
  std::vector<Index> pool_;              // what a strategy draws from
  std::vector<double> relative_gains_;   // of the survivors; or traces of all candidates
  std::vector<std::uint32_t> by_trace_;  // numbers of candidates
  std::vector<unsigned char> is_open_;   // per candidate: free, and not selected
};

// The three loops of the paper (strategies.cpp). Each selects until search.wants_more() is false, and returns ok, or
// deadline_reached where the time limit has passed before.

/// k rounds, each selecting the remaining candidate of maximum gain (Nemhauser et al. 1978).
Status greedy(Search& search) noexcept;
/// The answer of greedy with fewer evaluations: gains only decrease (submodularity), so a candidate whose last known
/// gain is below the best of this round need not be evaluated again (Minoux 1978), here by tiles.
Status lazy_greedy(Search& search) noexcept;
/// Algorithm 1 of the paper: in each round the best of a random sample of s = ceil(n / k ln(1 / epsilon)).
Status stochastic_greedy(Search& search, const StochasticOptions& options) noexcept;
/// The same with small samples and without a deadline: adds what a time limit has left missing.
void fill(Search& search) noexcept;

}  // namespace maxlogdet
