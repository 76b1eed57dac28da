// SPDX-License-Identifier: MIT
#include "kernel/strategies/method.hpp"

namespace maxlogdet {
namespace {

// k rounds, each selecting the remaining candidate of maximum gain (Nemhauser et al. 1978).
Status greedy(Search& search, const Options& /*options*/, Workspace* /*workspace*/) noexcept {
  search.screening.use_store(search.constraints.free(), search.candidates.size());
  while (search.wants_more()) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    search.screening.begin_round(search.factor);
    search.screening.evaluate_all();
    search.select_best();
  }
  return Status::ok;
}

}  // namespace

constexpr Method greedy_method = {greedy, any_options, 10000};

}  // namespace maxlogdet
