// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace maxlogdet::test {

/// Blocks in the order of their indices; an invalid candidate has none.
using Slots = std::vector<std::optional<Block>>;

/// 1 to 3 rows each; some duplicated, scaled, zero or nearly parallel to others.
std::vector<Block> random_blocks(Random& random, std::size_t n);

/// The same blocks with empty slots before, between and behind them.
Slots with_empty_slots(Random& random, const std::vector<Block>& blocks, double share);

/// Appends a candidate without a block, in any of the ways that there are.
std::size_t push_back_empty(Random& random, BlockStore& blocks);

void push_back_slot(Random& random, const std::optional<Block>& slot, BlockStore& blocks);

BlockStore store_of(Random& random, const Slots& slots);

/// Indices of the slots that have a block.
std::vector<std::uint32_t> present(const Slots& slots);

template <class T>
std::vector<T> gathered(const std::vector<T>& values, const std::vector<std::uint32_t>& indices) {
  std::vector<T> result;
  if (values.empty()) return result;
  for (const std::uint32_t i : indices) result.push_back(values[i]);
  return result;
}

/// The same request for a store that holds these candidates alone.
Request request_of(const Request& request, const std::vector<std::uint32_t>& indices);

/// Any subset of the constraints, perhaps with a certificate, for some of the blocks.
Request random_request(Random& random, const BlockStore& blocks);

/// Every strategy's answer for `whole` against that for `dense`, which holds the candidates `kept` of it alone.
void expect_same_answers(const BlockStore& whole, const Request& request, const BlockStore& dense,
                         const std::vector<std::uint32_t>& kept);

/// Leaves some matches without a block, for every reason that there is; returns which are usable.
std::vector<unsigned char> spoil(Random& random, double share, sim::Frame& frame);

/// Appends the blocks of a frame's usable matches.
BlockReport append(const sim::Frame& frame, const std::vector<unsigned char>& usable, const BlockKind& kind,
                   BlockStore& blocks);

}  // namespace maxlogdet::test
