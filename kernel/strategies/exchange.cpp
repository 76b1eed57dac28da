// SPDX-License-Identifier: MIT
#include "kernel/strategies/exchange.hpp"

#include "simd/rounding.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

// Tries to improve the positions of an answer one by one. Float32 screens, as in a round of greedy; float64 decides,
// and swaps only beyond its rounding error, so that log det never decreases (docs/numerics.md).
class Exchange {
 public:
  Exchange(Search& search, ExchangeWorkspace& own) noexcept
      : search_(search), unselected_(own.is_unselected.data()), open_(own.is_open.data()) {
    std::copy_n(search.constraints.free(), search.candidates.size(), unselected_);
    for (std::size_t j = 0; j < search.selected; ++j) unselected_[search.indices[j]] = 0;
  }

  // Puts the best candidate at this position of the answer; returns whether that changes it.
  bool improve(std::size_t position) noexcept {
    if (!has_bounds_) bound_relative_gains();
    const std::uint32_t out = search_.indices[position];
    const double f = search_.factor.relative_error();
    if (!(f < hopeless_error)) return false;
    // log det is concave: swapping i for j changes it by at most d_j - d_i, d = tr(H M^-1 H^T), and d_j is at most the
    // relative gain by j. For nearly all positions of an answer with 60 candidates this suffices.
    const auto threshold =
        static_cast<float>(share_of_information(out) * (1 - drift_of_error * f) * (1 - simd::sum_room));
    if (search_.screening.highest_bound() < threshold) return false;

    const InformationFactor before = search_.factor;
    remove(position);
    search_.constraints.give_room(out);
    if (search_.constraints.has_groups()) open_lanes();
    search_.screening.restart(search_.candidates.largest_of_form);
    search_.screening.begin_round(search_.factor);
    search_.screening.evaluate_trial(threshold);
    const std::size_t best = search_.find_best();
    const bool is_better = best != search_.screening.lanes() && gains_more(search_.screening.candidate(best), out);
    if (is_better) {
      insert(search_.screening.candidate(best), position);
    } else {
      search_.factor = before;
    }
    search_.constraints.take_room(search_.indices[position]);
    return is_better;
  }

  // Recomputes the factor and the gains of the answer, in order.
  void recompute_gains() noexcept {
    const std::size_t count = search_.selected;
    search_.factor = search_.prior;
    search_.selected = 0;
    while (search_.selected < count) search_.add(search_.indices[search_.selected]);
  }

 private:
  // Stale bounds, at the current information, of all unselected candidates, whether their group is full or not.
  void bound_relative_gains() noexcept {
    search_.screening.use_store(unselected_, search_.candidates.size());
    search_.screening.restart(search_.candidates.largest_of_form);
    search_.screening.begin_round(search_.factor);
    search_.screening.evaluate_all();
    search_.screening.end_round();
    has_bounds_ = true;
  }

  // tr(H M^-1 H^T).
  double share_of_information(std::uint32_t candidate) const noexcept {
    double trace = 0;
    search_.evaluator.exact_traces(search_.factor.inverse(), &candidate, 1, &trace);
    return trace;
  }

  void remove(std::size_t position) noexcept {
    const bool is_sound = search_.remove_rows(search_.indices[position]);
    if (is_sound && search_.factor.relative_error() < large_error) return;
    search_.factor = search_.prior;
    for (std::size_t j = 0; j < search_.selected; ++j) {
      if (j != position) search_.add_rows(search_.indices[j]);
    }
  }

  void insert(std::uint32_t candidate, std::size_t position) noexcept {
    unselected_[search_.indices[position]] = 1;
    unselected_[candidate] = 0;
    search_.indices[position] = candidate;
    search_.add_rows(candidate);
    has_bounds_ = false;
  }

  // Restricts the screening to candidates whose group has room.
  void open_lanes() noexcept {
    for (std::size_t i = 0; i < search_.candidates.size(); ++i) {
      const bool is_open = unselected_[i] != 0 && search_.constraints.has_room(static_cast<std::uint32_t>(i));
      open_[i] = is_open ? 1 : 0;
    }
    search_.screening.use_store(open_, search_.candidates.size());
  }

  bool gains_more(std::uint32_t candidate, std::uint32_t than) const noexcept {
    const std::uint32_t both[2] = {candidate, than};
    double relative_gains[2];
    search_.evaluator.decide(search_.factor.inverse(), both, 2, relative_gains);
    const double f = search_.factor.relative_error();
    const double omega = search_.factor.inverse_norm() * max_row_norm(search_.candidates.column_max());
    // Upper bound of the error of the difference of two gains, nats.
    const double error = drift_of_error * search_.candidates.rows() * f + 128 * simd::double_unit_roundoff * omega;
    return f < hopeless_error && relative_gains[0] - relative_gains[1] > error * (1 + relative_gains[0]);
  }

  Search& search_;
  unsigned char* unselected_;  // per candidate
  unsigned char* open_;        // per candidate
  bool has_bounds_ = false;
};

}  // namespace

Status exchange(Search& search, std::size_t sweeps, ExchangeWorkspace& own) noexcept {
  const std::size_t first = search.constraints.required_count();
  const std::size_t positions = search.selected - std::min(first, search.selected);
  Exchange exchange(search, own);
  std::size_t unchanged = 0;  // consecutive positions without a swap
  bool any = false;
  bool is_late = false;
  for (std::size_t sweep = 0; sweep < sweeps && unchanged < positions && !is_late; ++sweep) {
    for (std::size_t position = first; position < search.selected && unchanged < positions; ++position) {
      is_late = search.deadline.has_passed();
      if (is_late) break;
      const bool is_changed = exchange.improve(position);
      unchanged = is_changed ? 0 : unchanged + 1;
      any = any || is_changed;
    }
  }
  if (any) exchange.recompute_gains();
  return is_late ? Status::deadline_reached : Status::ok;
}

}  // namespace maxlogdet
