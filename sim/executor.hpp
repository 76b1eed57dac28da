// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/executor.hpp>

namespace maxlogdet::sim {

/// Where the project's own programs get helpers: oneTBB, one for all; nullptr in a build without.
Executor* executor();

}  // namespace maxlogdet::sim
