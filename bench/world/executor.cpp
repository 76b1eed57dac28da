// SPDX-License-Identifier: MIT
#include "bench/world/executor.hpp"

#if defined(MAXLOGDET_HAS_TBB)
#include <maxlogdet/tbb.hpp>
#endif

namespace maxlogdet::sim {

Executor* executor() {
#if defined(MAXLOGDET_HAS_TBB)
  static TbbExecutor tbb;
  return &tbb;
#else
  return nullptr;
#endif
}

}  // namespace maxlogdet::sim
