// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/problem.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// An upper bound of log det(M0 + sum of H^T H), nats, over all selections of at most `budget` candidates that hold all
/// required ones and otherwise only free ones; groups are ignored, which can only raise it. `w`: W of the information
/// of a selection; the better that is, the lower is the bound. Proved, including rounding (docs/numerics.md); +infinity
/// where nothing can be proved.
/// `traces`, `order`: scratch for all candidates.
double upper_bound(const Problem& problem, const double* w, std::size_t budget, double* traces,
                   std::uint32_t* order) noexcept;

}  // namespace maxlogdet
