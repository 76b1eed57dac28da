// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"
#include "kernel/search/strategy_memory.hpp"

namespace maxlogdet {

/// After a deadline: adds candidates until search.wants_more() is false, about as fast as they can be looked at once
/// and added. They are those of most information, at the information to be expected of a whole answer: at that of the
/// answer so far, nearly identical ones would be taken together. What it adds depends only on the answer so far, not on
/// the machine.
void fill(Search& search, StrategyMemory& memory) noexcept;

}  // namespace maxlogdet
