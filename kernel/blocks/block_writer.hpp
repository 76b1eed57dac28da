// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/block_planes.hpp"
#include "simd/blocks.hpp"
#include "threading/team.hpp"

#include <cstddef>

namespace maxlogdet {

/// Appends blocks to a store plane by plane, for append_blocks.
class BlockWriter {
 public:
  /// Makes room for `count` more candidates. Throws std::bad_alloc.
  BlockWriter(BlockStore& blocks, std::size_t count);

  /// Builds and appends input.size candidates; returns their counts and maxima.
  simd::BlockOutput append(const simd::BlockInput& input, threading::Team& team) noexcept;

 private:
  simd::BlockOutput build(const simd::BlockInput& input, std::size_t first, std::size_t size) const noexcept;

  void close_up(const simd::BlockOutput& part, std::size_t place) const noexcept;

  BlockPlanes& planes_;
};

}  // namespace maxlogdet
