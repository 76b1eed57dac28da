// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

namespace maxlogdet {

Status greedy(Search& search) noexcept {
  while (search.wants_more()) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    search.select(search.evaluate(0, search.candidates.size()));
  }
  return Status::ok;
}

}  // namespace maxlogdet
