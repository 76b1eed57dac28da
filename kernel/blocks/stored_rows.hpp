// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"

#include <maxlogdet/block_store.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Rounds a block, rows x 6 row-major, to float32, as a store does. Returns false if it is null, has another number of
/// rows, or float32 cannot hold it.
inline bool round_block(const double* block, int rows, float (&stored)[max_block_rows][state_dimension]) {
  if (block == nullptr || rows < 1 || rows > max_block_rows) return false;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      stored[row][column] = static_cast<float>(block[state_dimension * row + column]);
      if (!std::isfinite(stored[row][column])) return false;
    }
  }
  return true;
}

/// Reads the stored rows of a candidate, candidates.rows of them, into float64.
inline void read_rows(const Candidates& candidates, Candidate candidate,
                      double (&rows)[max_block_rows][state_dimension]) {
  for (int row = 0; row < candidates.rows; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      rows[row][column] = static_cast<double>(candidates.plane(row, column)[simd::number(candidate)]);
    }
  }
}

/// Whether two candidates have the same rows, entry for entry.
inline bool are_identical(const Candidates& candidates, Candidate a, Candidate b) noexcept {
  for (int e = 0; e < candidates.rows * state_dimension; ++e) {
    const float* const plane = candidates.plane(0, e);
    if (plane[simd::number(a)] < plane[simd::number(b)] || plane[simd::number(a)] > plane[simd::number(b)])
      return false;
  }
  return true;
}

}  // namespace maxlogdet
