// SPDX-License-Identifier: MIT
#include "kernel/selector_checks.hpp"

#include "kernel/strategies/method.hpp"

#include <limits>

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
  selection.log_det = std::numeric_limits<double>::quiet_NaN();
  selection.upper_bound = std::numeric_limits<double>::quiet_NaN();
  selection.threads = 1;
  selection.efficiency_of_all = std::numeric_limits<double>::quiet_NaN();
  selection.translation_sigma = std::numeric_limits<double>::quiet_NaN();
  selection.rotation_sigma = std::numeric_limits<double>::quiet_NaN();
  return selection;
}

}  // namespace maxlogdet
