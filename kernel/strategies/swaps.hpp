// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information.hpp"
#include "kernel/information/top_traces.hpp"
#include "kernel/search/search.hpp"

#include <cstddef>

namespace maxlogdet {

/// Swaps one of the `count` selected candidates, of small trace, for the best of the `available` ones that the
/// screening holds, while that increases log det, at most a few times. `information` is that of all selected
/// candidates. Leaves the answer of the search to the caller. Returns ok or deadline_reached.
Status swap_lowest_traces(Search& search, Candidate* selected, std::size_t count, std::size_t available,
                          Information information, TraceMemory& memory) noexcept;

}  // namespace maxlogdet
