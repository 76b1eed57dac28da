// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"

#include <maxlogdet/block_store.hpp>

#include <cmath>
#include <cstddef>

namespace maxlogdet {

/// A block, rows x 6 row-major, as a store holds it, in float32; false if that cannot hold it, or it is none.
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

/// The rows of candidate i as stored, in float64; candidates.rows() of them.
inline void read_rows(const Candidates& candidates, std::size_t i, double (&rows)[max_block_rows][state_dimension]) {
  for (int row = 0; row < candidates.rows(); ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      rows[row][column] = static_cast<double>(candidates.plane(row, column)[i]);
    }
  }
}

}  // namespace maxlogdet
