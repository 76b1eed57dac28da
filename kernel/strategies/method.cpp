// SPDX-License-Identifier: MIT
#include "kernel/strategies/method.hpp"

namespace maxlogdet {

// The switch has no default, so that compilers tell of an enumerator that MAXLOGDET_STRATEGIES lacks.
const Method* method_of(Strategy strategy) noexcept {
#define MAXLOGDET_CASE(name) \
  case Strategy::name: return &name##_method;
  switch (strategy) { MAXLOGDET_STRATEGIES(MAXLOGDET_CASE) }
#undef MAXLOGDET_CASE
  return nullptr;
}

}  // namespace maxlogdet
