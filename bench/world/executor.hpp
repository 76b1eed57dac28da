// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/selector.hpp>

namespace maxlogdet::sim {

/// Returns the executor that all of the project's programs share: oneTBB's, or nullptr in a build without oneTBB.
Executor* executor();

}  // namespace maxlogdet::sim
