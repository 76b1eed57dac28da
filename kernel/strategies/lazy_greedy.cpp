// SPDX-License-Identifier: MIT
#include "kernel/strategies/strategies.hpp"

#include <algorithm>

namespace maxlogdet {

// Until the selected rows span the state, gains are those against the prior and predict later ones poorly; so at least
// three rounds evaluate every candidate. The round after them does so once more, and the candidates are ordered by its
// gains.
Status lazy_greedy(Search& search) noexcept {
  Screening& screening = search.screening();
  const int rows = std::max(search.problem().candidates.rows, 1);
  const std::size_t min_selected =
      search.answer().size() + static_cast<std::size_t>(std::max(3, state_dimension / rows));
  screening.use_store(search.problem().is_free);
  while (search.wants_more()) {
    if (search.is_late()) return Status::deadline_reached;
    const bool is_order_due = !screening.layout().is_ordered() && search.answer().size() >= min_selected;
    screening.begin_round(search.answer().factor());
    const Lane best = search.find_best();
    screening.end_round();
    search.select(best);
    if (!is_order_due || !search.wants_more()) continue;
    if (search.is_late()) return Status::deadline_reached;
    screening.order_by_gain();  // about as long as a round
    if (search.constraints().has_groups()) screening.layout().find_lanes();
  }
  return Status::ok;
}

}  // namespace maxlogdet
