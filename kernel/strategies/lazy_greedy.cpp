// SPDX-License-Identifier: MIT
#include "kernel/strategies/lazy_greedy.hpp"

#include "kernel/strategies/method.hpp"

#include <algorithm>

namespace maxlogdet {

LazyRounds::LazyRounds(Search& search) noexcept
    : search_(search),
      start_(search.selected),
      first_rounds_(std::max<std::size_t>(3, state_dimension / static_cast<std::size_t>(search.screening.rows()))) {}

void LazyRounds::order() noexcept {
  search_.screening.order_by_gain(search_.constraints.has_groups());
  is_ordered_ = true;
  order_is_due_ = false;
}

void LazyRounds::evaluate(std::size_t k) noexcept {
  Screening& screening = search_.screening;
  if (!is_open_) screening.begin_round(search_.factor);
  if (is_ordered_) {
    screening.evaluate_promising(k);
  } else {
    if (!is_open_) screening.evaluate_all();
    if (is_open_ || k > 1) screening.look_again(k);
    order_is_due_ = search_.selected - start_ >= first_rounds_;
  }
  is_open_ = true;
}

void LazyRounds::finish() noexcept {
  if (is_ordered_) search_.screening.end_round();
  is_open_ = false;
}

Status search_lazily(Search& search) noexcept {
  LazyRounds rounds(search);
  while (search.wants_more()) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    if (rounds.order_is_due()) {
      rounds.order();  // about as long as a round
      continue;
    }
    rounds.evaluate();
    const std::size_t lane = search.find_best();
    rounds.finish();
    search.select(lane);
  }
  return Status::ok;
}

Status lazy_greedy(Search& search) noexcept {
  search.screening.use_store(search.constraints.free(), search.candidates.size());
  return search_lazily(search);
}

namespace {

Status run(Search& search, const Options& /*options*/, Workspace* /*workspace*/) noexcept {
  return lazy_greedy(search);
}

}  // namespace

constexpr Method lazy_greedy_method = {run, any_options, 100000};

}  // namespace maxlogdet
