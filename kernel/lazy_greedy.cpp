// SPDX-License-Identifier: MIT
#include "kernel/lazy_greedy.hpp"

#include "kernel/method.hpp"

#include <algorithm>

namespace maxlogdet {

LazyRounds::LazyRounds(Search& search) noexcept
    : search_(search),
      start_(search.selected),
      first_rounds_(std::max<std::size_t>(3, state_dimension / static_cast<std::size_t>(search.screening.rows()))) {}

bool LazyRounds::order_is_due() const noexcept { return !is_ordered_ && added() == first_rounds_ + 1; }

void LazyRounds::order() noexcept {
  search_.screening.order_by_gain(search_.constraints.has_groups());
  is_ordered_ = true;
}

void LazyRounds::evaluate() noexcept {
  search_.screening.begin_round(search_.factor);
  if (added() <= first_rounds_) {
    search_.screening.evaluate_all();
  } else {
    search_.screening.evaluate_promising();
  }
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
    search.select_best();
  }
  return Status::ok;
}

Status lazy_greedy(Search& search) noexcept {
  search.screening.use_store(search.constraints.free(), search.candidates.size());
  return search_lazily(search);
}

namespace {

Status run(Search& search, const Options& /*options*/) noexcept { return lazy_greedy(search); }

}  // namespace

constexpr Method lazy_greedy_method = {run, any_options, 100000};

}  // namespace maxlogdet
