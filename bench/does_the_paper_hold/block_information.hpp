// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>

namespace maxlogdet::sim {

/// Returns H^T H of a candidate that has a block.
inline Matrix6 information_of(const BlockStore& blocks, std::size_t i) {
  double entries[max_block_rows * state_dimension];
  const int rows = blocks.block(i, entries);
  Matrix6 information = Matrix6::Zero();
  for (int row = 0; row < rows; ++row) {
    const Vector6 h(entries + state_dimension * row);
    information += h * h.transpose();
  }
  return information;
}

}  // namespace maxlogdet::sim
