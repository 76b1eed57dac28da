// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>

#include <cstddef>

namespace maxlogdet {

/// The rows of candidate i as stored, in float64; blocks.rows() of them.
inline void read_rows(const BlockStore& blocks, std::size_t i, double (&rows)[max_block_rows][state_dimension]) {
  for (int row = 0; row < blocks.rows(); ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      rows[row][column] = static_cast<double>(blocks.plane(row, column)[i]);
    }
  }
}

}  // namespace maxlogdet
