// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

namespace maxlogdet {

// Until the selected rows span the state, gains are those against the prior and say little about later ones; the first
// round after that evaluates every candidate once more and orders them by what it finds.
Status lazy_greedy(Search& search) noexcept {
  const auto rows = static_cast<std::size_t>(search.screening.rows());
  const std::size_t rounds_to_full_rank = state_dimension / rows + (rows == 3 ? 1 : 0);

  search.screening.use_store(search.candidates.validity(), search.candidates.size());
  while (search.wants_more()) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    search.screening.begin_round(search.factor);
    if (search.selected <= rounds_to_full_rank) {
      search.screening.evaluate_all();
    } else {
      search.screening.evaluate_promising();
    }
    search.select_best();
    if (search.selected == rounds_to_full_rank + 1) search.screening.order_by_gain();
  }
  return Status::ok;
}

}  // namespace maxlogdet
