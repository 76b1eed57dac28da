// SPDX-License-Identifier: MIT
#include "kernel/search/search.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

Search::Search(std::size_t capacity)
    : kernel_(simd::active()),
      constraints_(checked_capacity(capacity)),
      screening_(capacity, team_),
      indices_(capacity),
      gains_(capacity),
      sizes_(padded(capacity)),
      survivors_(padded(capacity)),
      deciding_(capacity),
      pool_(capacity),
      relative_gains_(padded(capacity)),
      by_trace_(capacity),
      is_open_(capacity) {}

Error Search::start(const Candidates& candidates, const Options& options, const Deadline& deadline) noexcept {
  candidates_ = candidates;
  deadline_ = deadline;
  target_efficiency_ = options.target_efficiency;
  budget_ = std::min(options.budget, capacity());
  size_ = decisions_ = 0;
  const Error error = constraints_.reset(candidates_, options);
  if (error != Error::none) return error;
  if (!prior_.start(options.prior, candidates_, sizes_, at_prior_)) return Error::invalid_prior;
  factor_ = at_prior_;
  remaining_ = constraints_.free_count();
  screening_.start(candidates_);
  if (target_efficiency_ > 0) compare_with_all();
  for (std::size_t j = 0; j < constraints_.required_count(); ++j) take(constraints_.required()[j]);
  return Error::none;
}

double Search::add_rows(Index candidate, InformationFactor& to) const noexcept {
  double rows[max_block_rows][state_dimension];
  candidates_.read_rows(candidate, rows);
  return to.add_block(*kernel_, rows, candidates_.rows);
}

Lane Search::find_best() noexcept {
  const std::size_t count = screening_.survivors(factor_, survivors_.data());
  assert(count > 0);
  if (count == 1) return survivors_[0];
  for (std::size_t j = 0; j < count; ++j) deciding_[j] = candidate(survivors_[j]);
  double* const gains = relative_gains_.data();
  candidates_.exact().decide(candidates_.planes, factor_.inverse(), deciding_.data(), count, gains);
  decisions_ += count;
  std::size_t best = 0;
  for (std::size_t j = 1; j < count; ++j) {
    if (gains[j] > gains[best] || (gains[j] == gains[best] && deciding_[j] < deciding_[best])) best = j;
  }
  return survivors_[best];
}

// Removes the lane before the candidate is added, so that its stores complete well before vector loads of the next
// round read them.
void Search::select(Lane lane) noexcept {
  const TileLayout& layout = screening_.layout();
  const Index selected = layout.candidate(lane);
  reject(lane);
  constraints_.take_room(selected);
  if (!constraints_.has_room(selected) && layout.has_lane_of()) {
    constraints_.for_group_of(selected, [&](Index member) {
      const Lane lane_of_member = layout.lane_of(member);
      if (lane_of_member != no_lane) reject(lane_of_member);
    });
  }
  take(selected);
}

void Search::take(Index candidate) noexcept {
  indices_[size_] = static_cast<std::uint32_t>(candidate);
  gains_[size_++] = std::log1p(add_rows(candidate, factor_));
}

void Search::reject(Lane lane) noexcept {
  screening_.remove(lane);
  --remaining_;
}

Index* Search::list_remaining() noexcept {
  std::copy_n(constraints_.free(), candidates_.count, is_open_.data());
  for (std::size_t j = 0; j < size_; ++j) is_open_[indices_[j]] = 0;
  remaining_ = 0;
  for (std::size_t i = 0; i < candidates_.count; ++i) {
    if (is_open_[i] != 0 && has_room(static_cast<Index>(i))) pool_[remaining_++] = static_cast<Index>(i);
  }
  screening_.layout().make_records();
  return pool_.data();
}

void Search::drop_closed(Index* list) noexcept {
  Index* const end = std::remove_if(list, list + remaining_, [&](Index i) { return !has_room(i); });
  remaining_ = static_cast<std::size_t>(end - list);
}

// The target: det M / det M_all is the product of (1 / (W_cc L_cc))^2, L the Cholesky factor of M_all. No factor is
// above 1: L_cc^2, a Schur complement, only increases with information.

void Search::compare_with_all() noexcept {
  InformationFactor all = at_prior_;
  for (std::size_t i = 0; i < candidates_.count; ++i) {
    if (candidates_.valid[i] != 0) add_rows(static_cast<Index>(i), all);
  }
  for (int c = 0; c < state_dimension; ++c) diagonal_of_all_[c] = 1 / all.inverse()[simd::padded_dimension * c + c];
}

// W_cc L_cc.
double Search::against_all(int c) const noexcept {
  return factor_.inverse()[simd::padded_dimension * c + c] * diagonal_of_all_[c];
}

// In pairs, each scaled by the target, the products leave the range of float64 only where the answer is clear
// (docs/numerics.md); and in one order only, so that a selection ends at the same candidate on every machine. NaN does
// not meet the target.
bool Search::meets_target() const noexcept {
  if (target_efficiency_ == 0) return false;
  double product = 1;
  for (int c = 0; c < state_dimension; c += 2) product *= against_all(c) * against_all(c + 1) * target_efficiency_;
  return product <= 1;
}

double Search::efficiency() const noexcept {
  double root = 1;
  for (int c = 0; c < state_dimension; ++c) root *= std::cbrt(against_all(c));
  return 1 / root;
}

double Search::log_det() const noexcept {
  return std::accumulate(gains_.data(), gains_.data() + size_, at_prior_.prior_log_det());
}

void Search::report(Status status, Selection& selection) const noexcept {
  const bool takes_all = candidates_.count > 0 && budget_ > 0 && remaining_ == 0;
  selection.status = meets_target()                      ? Status::target_reached
                     : status == Status::ok && takes_all ? Status::all_selected
                                                         : status;
  selection.indices = indices_.data();
  selection.gains = gains_.data();
  selection.size = size_;
  selection.log_det = log_det();
  if (target_efficiency_ > 0) selection.efficiency = efficiency();
  selection.evaluations = screening_.evaluations();
  selection.float64_decisions = decisions_;
}

}  // namespace maxlogdet
