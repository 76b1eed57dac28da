// SPDX-License-Identifier: MIT
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>
#include <maxlogdet/version.hpp>

namespace maxlogdet {

const char* version() noexcept { return MAXLOGDET_VERSION; }

const char* to_string(Strategy strategy) noexcept {
#define MAXLOGDET_CASE(name) \
  case Strategy::name: return #name;
  switch (strategy) { MAXLOGDET_STRATEGIES(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return "unknown";
}

const char* to_string(Status status) noexcept {
  switch (status) {
    case Status::ok: return "ok";
    case Status::all_selected: return "all_selected";
    case Status::deadline_reached: return "deadline_reached";
    case Status::invalid_budget: return "invalid_budget";
    case Status::invalid_epsilon: return "invalid_epsilon";
    case Status::invalid_prior: return "invalid_prior";
    case Status::capacity_exceeded: return "capacity_exceeded";
    case Status::invalid_strategy: return "invalid_strategy";
    case Status::invalid_time_limit: return "invalid_time_limit";
    case Status::invalid_threads: return "invalid_threads";
    case Status::invalid_groups: return "invalid_groups";
    case Status::infeasible: return "infeasible";
    case Status::unsupported_groups: return "unsupported_groups";
    case Status::nothing_proposed: return "nothing_proposed";
    case Status::invalid_block: return "invalid_block";
    case Status::unsupported_isa: return "unsupported_isa";
    case Status::target_reached: return "target_reached";
    case Status::invalid_target: return "invalid_target";
    case Status::unsupported_target: return "unsupported_target";
  }
  return "unknown";
}

}  // namespace maxlogdet
