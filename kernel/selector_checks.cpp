// SPDX-License-Identifier: MIT
#include "kernel/selector_checks.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/strategies/method.hpp"

namespace maxlogdet {

Status check(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept {
  if (memory.kernel == nullptr) return Status::unsupported_isa;
  if (candidates.size() > memory.capacity) return Status::capacity_exceeded;
  if (options.budget > memory.capacity) return Status::invalid_budget;
  if (!(options.time_limit >= 0)) return Status::invalid_time_limit;
  if (options.threads < 0) return Status::invalid_threads;
  const Status of_target = Target::check(options);
  if (of_target != Status::ok) return of_target;
  const Method* const method = method_of(options.strategy);
  return method == nullptr ? Status::invalid_strategy : method->check(options);
}

Selection empty_selection(Status status) noexcept {
  Selection selection{};
  selection.status = status;
  selection.log_det = not_a_number;
  selection.upper_bound = not_a_number;
  selection.threads = 1;
  selection.efficiency_of_all = not_a_number;
  selection.translation_sigma = not_a_number;
  selection.rotation_sigma = not_a_number;
  return selection;
}

}  // namespace maxlogdet
