// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// The free candidates of largest trace d_i = |H_i W^T|_F^2.
struct TopTraces {
  const std::uint32_t* candidates;  ///< in ascending order; in the scratch of the search
  std::size_t count;
  double sum;       ///< of their d_i
  float threshold;  ///< about the smallest of them: where to look for it next time
};

/// The `wanted` free candidates of largest d_i, or all if there are fewer; d_i in float64, ties to the lowest index:
/// the same on every instruction set and number of threads. `w`: 6 x 8 row-major, lower triangular. `guess`: a
/// threshold that was found with a similar one; it saves time. Uses `traces`, `relative gains`, `lanes` and
/// `contenders` of the search.
TopTraces find_top_traces(Search& search, const double* w, std::size_t wanted, float guess) noexcept;

/// A guess for want of a better one: at an optimum the largest d_i sum to at most 6.
inline float first_guess(std::size_t wanted) noexcept { return 3.0F / static_cast<float>(wanted + 1); }

/// A bound of | |H W^T|_F - |H W^T|_F as computed | for every candidate, in units of the unit roundoff and to first
/// order, from rounding W and forming H W^T (docs/numerics.md).
double trace_root_error(const Search& search, const double* w) noexcept;

}  // namespace maxlogdet
