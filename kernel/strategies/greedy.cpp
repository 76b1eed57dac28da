// SPDX-License-Identifier: MIT
#include "kernel/strategies/method.hpp"

namespace maxlogdet {
namespace {

// k rounds, each selecting the remaining candidate of maximum gain (Nemhauser et al. 1978).
Status greedy(Search& search, const Options& /*options*/, StrategyMemory& /*memory*/) noexcept {
  search.screening().use_store(search.problem().is_free, search.problem().candidates.count);
  while (search.wants_more()) {
    if (search.is_late()) return Status::deadline_reached;
    search.screening().begin_round(search.answer().factor());
    const Lane best = search.find_best();
    search.screening().end_round();
    search.select(best);
  }
  return Status::ok;
}

}  // namespace

constexpr Method greedy_method = {greedy, any_options, 10000};

}  // namespace maxlogdet
