// SPDX-License-Identifier: MIT
#include "kernel/strategies/lazy_greedy.hpp"

#include "kernel/strategies/method.hpp"

#include <algorithm>

namespace maxlogdet {

LazyRounds::LazyRounds(Search& search) noexcept
    : search_(search),
      min_selected_(
          search.answer().size() +
          std::max<std::size_t>(3, state_dimension / static_cast<std::size_t>(search.problem().evaluator.rows()))) {}

void LazyRounds::order() noexcept {
  search_.screening().order_by_gain();
  if (search_.constraints().has_groups()) search_.screening().layout().find_lanes();
  order_is_due_ = false;
}

void LazyRounds::open() noexcept {
  if (is_open_) return;
  search_.screening().begin_round(search_.answer().factor());
  order_is_due_ = !search_.screening().layout().is_ordered() && search_.answer().size() >= min_selected_;
  is_open_ = true;
}

void LazyRounds::close() noexcept {
  if (is_open_) search_.screening().end_round();
  is_open_ = false;
}

Status search_lazily(Search& search) noexcept {
  LazyRounds rounds(search);
  while (search.wants_more()) {
    if (search.is_late()) return Status::deadline_reached;
    if (rounds.order_is_due()) {
      rounds.order();  // about as long as a round
      continue;
    }
    rounds.open();
    const Lane best = search.find_best();
    rounds.close();
    search.select(best);
  }
  return Status::ok;
}

Status lazy_greedy(Search& search) noexcept {
  search.screening().use_store(search.problem().is_free, search.problem().candidates.count);
  return search_lazily(search);
}

namespace {

Status run(Search& search, const Options& /*options*/, StrategyMemory& /*memory*/) noexcept {
  return lazy_greedy(search);
}

}  // namespace

constexpr Method lazy_greedy_method = {run, any_options, 100000};

}  // namespace maxlogdet
