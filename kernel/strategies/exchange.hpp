// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"
#include "kernel/search/strategy_memory.hpp"

#include <cstddef>

namespace maxlogdet {

/// At most `sweeps` sweeps over the answer. Each replaces every candidate that is not required by the best unselected
/// one if that increases log det (Fedorov 1972); log det never decreases. At the deadline the answer so far is kept.
Status exchange(Search& search, std::size_t sweeps, StrategyMemory& memory) noexcept;

}  // namespace maxlogdet
