// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information.hpp"
#include "kernel/search/search.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Swaps one of the least valuable of `count` selected candidates for the best of the `available` ones that the
/// screening holds, as long as that gains anything, a few times at most. `information` is that of all that is selected.
/// Leaves factor and gains of the search to be made anew. ok or deadline_reached.
Status swap_least_valuable(Search& search, std::uint32_t* selected, std::size_t count, std::size_t available,
                           Information information) noexcept;

}  // namespace maxlogdet
