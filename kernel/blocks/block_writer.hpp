// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"
#include "threading/team.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>

namespace maxlogdet {

/// How append_blocks writes whole planes of a store.
class BlockWriter {
 public:
  /// Makes room for `count` more candidates; throws std::bad_alloc.
  BlockWriter(BlockStore& blocks, std::size_t count);

  /// Makes the candidates, `input.size` of them, and counts them in.
  simd::BlockOutput append(const simd::BlockInput& input, threading::Team& team) noexcept;

 private:
  simd::BlockOutput build(const simd::BlockInput& input, std::size_t first, std::size_t size) const noexcept;

  void close_up(const simd::BlockOutput& part, std::size_t place) const noexcept;

  BlockStore& blocks_;
};

}  // namespace maxlogdet
