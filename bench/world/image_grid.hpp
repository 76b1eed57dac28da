// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace maxlogdet::sim {

/// The cells of an image: the paper's buckets.
struct ImageGrid {
  int columns = 1;
  int rows = 1;

  std::size_t cells() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }

  /// Returns the cell of a match; pixels outside of the image belong to the nearest cell.
  std::uint32_t cell_of(const Frame& frame, const Match& match) const {
    return static_cast<std::uint32_t>(columns * part(match.v - frame.top, frame.height, rows) +
                                      part(match.u - frame.left, frame.width, columns));
  }

 private:
  static int part(double pixel, double size, int parts) {
    const double position = pixel / (size > 0 ? size : 1) * parts;
    return position > 0 ? static_cast<int>(std::min<double>(position, parts - 1)) : 0;
  }
};

}  // namespace maxlogdet::sim
