// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <cstddef>

namespace maxlogdet {

/// An upper bound of log det(M0 + sum of H^T H), nats, over all selections of at most the search's budget that hold all
/// required candidates and none that is excluded; groups are left out, which can only raise it. Proved, rounding
/// included (docs/numerics.md); +infinity where nothing can be. Starts from what the search has selected, and tightens
/// it by Frank-Wolfe passes, as long as the deadline has not passed.
double upper_bound(Search& search, std::size_t passes) noexcept;

}  // namespace maxlogdet
