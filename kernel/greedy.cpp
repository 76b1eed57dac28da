// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

namespace maxlogdet {

Status greedy(Search& search) noexcept {
  search.screening.use_store(search.constraints.free(), search.candidates.size());
  while (search.wants_more()) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    search.screening.begin_round(search.factor);
    search.screening.evaluate_all();
    search.select_best();
  }
  return Status::ok;
}

}  // namespace maxlogdet
