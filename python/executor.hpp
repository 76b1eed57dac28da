// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/executor.hpp>

namespace maxlogdet::python {

/// Where helpers come from: oneTBB if the module was built with it, else nullptr. Never destroyed before what uses it.
Executor* executor() noexcept;

bool has_executor() noexcept;

}  // namespace maxlogdet::python
