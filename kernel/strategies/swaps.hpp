// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information.hpp"
#include "kernel/search/search.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Memory of swap_least_valuable among up to `capacity` candidates.
struct SwapMemory {
  explicit SwapMemory(std::size_t capacity) : traces(capacity), order(capacity) {}
  std::vector<double> traces;        ///< of the selected candidates
  std::vector<std::uint32_t> order;  ///< their places, partly ordered by trace
};

/// Swaps one of the least valuable of `count` selected candidates for the best of the `available` ones that the
/// screening holds, as long as that gains anything, a few times at most. `information` is that of all that is selected.
/// Afterwards the factor and the gains of the search have to be computed anew. ok or deadline_reached.
Status swap_least_valuable(Search& search, std::uint32_t* selected, std::size_t count, std::size_t available,
                           Information information, SwapMemory& memory) noexcept;

}  // namespace maxlogdet
