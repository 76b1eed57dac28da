// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/executor.hpp>

namespace maxlogdet::python {

/// oneTBB if the module was built with it, else null. Outlives every selector.
Executor* executor() noexcept;

bool has_executor() noexcept;

}  // namespace maxlogdet::python
