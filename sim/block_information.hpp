// SPDX-License-Identifier: MIT
#pragma once

#include "sim/se3.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>

namespace maxlogdet::sim {

/// Returns H^T H of a candidate that has a block.
inline Matrix6 information_of(const BlockStore& blocks, std::size_t i) {
  const std::size_t place = blocks.place(i);
  Matrix6 information = Matrix6::Zero();
  for (int row = 0; row < blocks.rows(); ++row) {
    Vector6 h;
    for (int column = 0; column < state_dimension; ++column) {
      h[column] = static_cast<double>(blocks.plane(row, column)[place]);
    }
    information += h * h.transpose();
  }
  return information;
}

}  // namespace maxlogdet::sim
