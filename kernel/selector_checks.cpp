// SPDX-License-Identifier: MIT
#include "kernel/selector_checks.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/strategies/method.hpp"

namespace maxlogdet {

Error check(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept {
  if (memory.kernel == nullptr) return Error::unsupported_isa;
  if (candidates.size() > memory.capacity) return Error::capacity_exceeded;
  if (!(options.time_limit >= 0)) return Error::invalid_time_limit;
  if (options.threads < 0) return Error::invalid_threads;
  const Error of_target = Target::check(options);
  if (of_target != Error::none) return of_target;
  const Method* const method = method_of(options.strategy);
  return method == nullptr ? Error::invalid_strategy : method->check(options);
}

Selection empty_selection(Error error) noexcept {
  Selection selection{};
  selection.status = error == Error::none ? Status::ok : Status::error;
  selection.error = error;
  selection.log_det = not_a_number;
  selection.upper_bound = not_a_number;
  selection.threads = 1;
  selection.efficiency = not_a_number;
  selection.translation_sigma = not_a_number;
  selection.rotation_sigma = not_a_number;
  return selection;
}

}  // namespace maxlogdet
