// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <cstddef>
#include <type_traits>
#include <vector>

// Stores of candidates of every sort.

namespace maxlogdet::test {

/// The n blocks that make(i) returns.
template <class Make>
BlockStore store_of(std::size_t n, const Make& make) {
  static_assert(std::is_same<decltype(make(n)), Block>::value, "an expression might refer to what is gone");
  BlockStore blocks;
  for (std::size_t i = 0; i < n; ++i) push_back(blocks, make(i));
  return blocks;
}

inline BlockStore store_of(const std::vector<Block>& blocks) {
  return store_of(blocks.size(), [&](std::size_t i) { return blocks[i]; });
}

inline BlockStore copies_of(const Block& block, std::size_t n) {
  return store_of(n, [&](std::size_t) { return block; });
}

/// Blocks of `rows` rows, or of 1 to 3, with entries uniform in [-scale, scale].
BlockStore random_store(Random& random, std::size_t n, double scale = 1, int rows = 0);

/// Blocks of any size that leave directions unobserved or nearly so: the information has a condition number of up to
/// 1e30, and its sum in float64 is singular, so that it is computed row by row.
BlockStore ill_conditioned_blocks(Random& random, std::size_t n);

/// The blocks times `scale`; a share of them becomes invalid.
BlockStore scaled(Random& random, const BlockStore& blocks, double scale, double invalid_share = 0);

/// The valid candidates of a store, by their rows alone: the new store does not know that append_blocks built them.
/// Invalid ones are kept.
BlockStore pushed(const BlockStore& blocks);

/// Blocks of 2 rows, of 3 rows that append_blocks built, of 3 rows that were pushed, or of every sort.
BlockStore any_blocks(Random& random, std::size_t n);

}  // namespace maxlogdet::test
