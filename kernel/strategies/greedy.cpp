// SPDX-License-Identifier: MIT
#include "kernel/strategies/strategies.hpp"

namespace maxlogdet {

Status greedy(Search& search) noexcept {
  search.screening().use_store(search.problem().is_free);
  while (search.wants_more()) {
    if (search.is_late()) return Status::deadline_reached;
    search.screening().begin_round(search.answer().factor());
    const Lane best = search.find_best();
    search.screening().end_round();
    search.select(best);
  }
  return Status::ok;
}

}  // namespace maxlogdet
