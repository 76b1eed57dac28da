// SPDX-License-Identifier: MIT
#include "kernel/strategies/exchange.hpp"

#include "kernel/base/limits.hpp"
#include "simd/rounding.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

// Tries to improve the positions of an answer one by one. Float32 screens, as in a round of greedy; float64 decides,
// and swaps only beyond its rounding error, so that log det never decreases (docs/numerics.md).
class Exchange {
 public:
  Exchange(Search& search, StrategyMemory& memory) noexcept
      : search_(search),
        problem_(search.problem()),
        is_unselected_(memory.remains),
        is_open_(memory.is_counted),
        answer_(memory.answer),
        factor_(search.answer().factor()) {
    mark_unselected(search, is_unselected_);
    std::copy_n(search.answer().candidates(), search.answer().size(), answer_);
  }

  // Puts the best candidate at this position of the answer; returns whether that changes it.
  bool improve(std::size_t position) noexcept {
    const double f = factor_.relative_error();
    if (!(f < hopeless_error)) return false;
    if (!has_bounds_) bound_relative_gains();
    // log det is concave: swapping i for j changes it by at most d_j - d_i, d = tr(H M^-1 H^T), and d_j is at most the
    // relative gain by j. For nearly all positions of an answer with 60 candidates this suffices.
    const Candidate out = answer_[position];
    const auto threshold =
        static_cast<float>(share_of_information(out) * (1 - drift_of_error * f) * (1 - simd::sum_room));
    if (highest_bound_ < threshold) return false;

    InformationFactor without = factor_without(position);
    Constraints& constraints = search_.constraints();
    constraints.give_room(out);
    if (constraints.has_groups()) close_full_groups();
    const Lane best = search_.find_best_at(without, threshold);
    const Candidate in = best == no_lane ? out : search_.screening().layout().candidate(best);
    const bool is_better = best != no_lane && gains_more(in, out, without);
    if (is_better) {
      add_rows(problem_, in, without);
      factor_ = without;
      is_unselected_[out] = 1;
      is_unselected_[in] = 0;
      answer_[position] = in;
      has_bounds_ = false;
    }
    constraints.take_room(answer_[position]);
    return is_better;
  }

 private:
  // Stale bounds, at the current information, of all unselected candidates, whether their group is full or not.
  void bound_relative_gains() noexcept {
    Screening& screening = search_.screening();
    screening.use_store(is_unselected_.data(), problem_.candidates.count);
    highest_bound_ = screening.bound_all(factor_);
    has_bounds_ = true;
  }

  // tr(H M^-1 H^T).
  double share_of_information(Candidate candidate) const noexcept {
    double trace = 0;
    problem_.evaluator.traces(factor_.inverse(), &candidate, 1, &trace);
    return trace;
  }

  InformationFactor factor_without(std::size_t position) const noexcept {
    InformationFactor without = factor_;
    if (remove_rows(problem_, answer_[position], without) && without.relative_error() < large_error) return without;
    without = search_.answer().prior();
    for (std::size_t j = 0; j < search_.answer().size(); ++j) {
      if (j != position) add_rows(problem_, answer_[j], without);
    }
    return without;
  }

  // Restricts the screening to candidates whose group has room.
  void close_full_groups() noexcept {
    for (std::size_t i = 0; i < problem_.candidates.count; ++i) {
      const auto candidate = static_cast<Candidate>(i);
      is_open_[candidate] = search_.constraints().has_room(candidate) ? is_unselected_[candidate] : 0;
    }
    search_.screening().restrict_to(is_open_.data());
  }

  bool gains_more(Candidate in, Candidate out, const InformationFactor& without) const noexcept {
    const Candidate both[2] = {in, out};
    double relative_gains[2];
    problem_.evaluator.decide(without.inverse(), both, 2, relative_gains);
    const double f = without.relative_error();
    const double omega = without.inverse_norm() * max_row_norm(problem_.candidates.column_max);
    // Upper bound of the error of the difference of two gains, nats.
    const double error = drift_of_error * problem_.candidates.rows * f + 128 * simd::double_unit_roundoff * omega;
    return f < hopeless_error && relative_gains[0] - relative_gains[1] > error * (1 + relative_gains[0]);
  }

  Search& search_;
  const Problem& problem_;
  ArrayOf<Candidate, unsigned char>& is_unselected_;  // whether it is free and not in the answer
  ArrayOf<Candidate, unsigned char>& is_open_;        // the same, and its group has room
  Candidate* answer_;                                 // with the swaps so far
  InformationFactor factor_;                          // of the prior and answer_
  float highest_bound_ = 0;
  bool has_bounds_ = false;
};

}  // namespace

Status exchange(Search& search, std::size_t sweeps, StrategyMemory& memory) noexcept {
  const std::size_t size = search.answer().size();
  const std::size_t first = std::min(search.problem().required_count, size);
  Exchange exchange(search, memory);
  std::size_t unchanged = 0;  // consecutive positions without a swap
  bool any = false;
  bool is_late = false;
  for (std::size_t sweep = 0; sweep < sweeps && unchanged < size - first && !is_late; ++sweep) {
    for (std::size_t position = first; position < size && unchanged < size - first; ++position) {
      is_late = search.is_late();
      if (is_late) break;
      const bool is_changed = exchange.improve(position);
      unchanged = is_changed ? 0 : unchanged + 1;
      any = any || is_changed;
    }
  }
  if (any) search.restart_with(memory.answer + first, size - first);
  return is_late ? Status::deadline_reached : Status::ok;
}

}  // namespace maxlogdet
