// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace maxlogdet {

/// Upper bounds of |y|^2 for any whitened row y = W h, given the maximum |entry| of each column of H.
struct WhitenedRowBounds {
  double squares;    ///< | |W| d |^2, d the column maxima
  double frobenius;  ///< |W diag(d)|_F^2: at least 1/6 of `squares`; never increases as rows are added
};

/// `w`: W = L^-1, 6 x 8 row-major, lower triangular. |Entries| of W count as at least simd::smallest_entry.
inline WhitenedRowBounds bound_whitened_rows(const double* w, const double* column_max) noexcept {
  WhitenedRowBounds bounds{0, 0};
  for (int c = 0; c < simd::dimension; ++c) {
    const double* const row = w + static_cast<std::size_t>(simd::padded_dimension * c);
    double sums[2] = {0, 0};  // two independent chains of additions, for speed
    for (int d = 0; d <= c; ++d) {
      constexpr double floor = simd::smallest_entry;
      sums[d % 2] += std::max(std::abs(row[d]), floor) * column_max[d];
      bounds.frobenius += (row[d] * row[d] + floor * floor) * (column_max[d] * column_max[d]);
    }
    bounds.squares += (sums[0] + sums[1]) * (sums[0] + sums[1]);
  }
  return bounds;
}

}  // namespace maxlogdet
