// SPDX-License-Identifier: MIT
#include "python/executor.hpp"

#ifdef MAXLOGDET_PYTHON_TBB
#include <maxlogdet/tbb.hpp>
#endif

namespace maxlogdet::python {

#ifdef MAXLOGDET_PYTHON_TBB
Executor* executor() noexcept {
  static TbbExecutor tbb;  // stateless, so its destruction is harmless
  return &tbb;
}
#else
Executor* executor() noexcept { return nullptr; }
#endif

bool has_executor() noexcept { return executor() != nullptr; }

}  // namespace maxlogdet::python
