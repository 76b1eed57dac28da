// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

#include <algorithm>

namespace maxlogdet {

// Until the selected rows span the state, gains are those against the prior and say little about later ones; so three
// rounds at least evaluate every candidate. The round after that does so once more, and orders them by what it finds.
Status search_lazily(Search& search) noexcept {
  const auto rows = static_cast<std::size_t>(search.screening.rows());
  const std::size_t first_rounds = std::max<std::size_t>(3, state_dimension / rows);
  for (std::size_t round = 0; search.wants_more(); ++round) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    search.screening.begin_round(search.factor);
    if (round <= first_rounds) {
      search.screening.evaluate_all();
    } else {
      search.screening.evaluate_promising();
    }
    search.select_best();
    if (round == first_rounds && search.wants_more()) {
      if (search.deadline.has_passed()) return Status::deadline_reached;
      search.screening.order_by_gain(search.constraints.has_groups());
    }
  }
  return Status::ok;
}

Status lazy_greedy(Search& search) noexcept {
  search.screening.use_store(search.constraints.free(), search.candidates.size());
  return search_lazily(search);
}

}  // namespace maxlogdet
