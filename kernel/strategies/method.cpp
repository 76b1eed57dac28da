// SPDX-License-Identifier: MIT
#include "kernel/strategies/method.hpp"

namespace maxlogdet {

// The switch has no default, so that compilers report an enumerator that MAXLOGDET_STRATEGIES lacks.
const Method* method_of(Strategy strategy) noexcept {
#define MAXLOGDET_CASE(name) \
  case Strategy::name: return &name##_method;
  switch (strategy) { MAXLOGDET_STRATEGIES(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return nullptr;
}

bool supports_groups_and_targets(Strategy strategy) noexcept {
  const Method* const method = method_of(strategy);
  const std::uint32_t group = 0;
  Options options;
  options.groups.ids = &group;
  options.target.efficiency = 1;
  return method != nullptr && method->check(options) == Error::none;
}

}  // namespace maxlogdet
