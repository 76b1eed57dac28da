// SPDX-License-Identifier: MIT
// A store with empty slots against a model that is a list of blocks, after any change.
#include "kernel/blocks/block_planes.hpp"
#include "tests/core/slots.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <new>
#include <utility>

namespace maxlogdet::test {
namespace {

// Appends a slot, with a block or without.
void push_back_random(Random& random, BlockStore& blocks, Slots& slots) {
  slots.emplace_back();
  if (random.chance(0.5)) slots.back() = random_block(random, random.integer(1, 3));
  push_back_slot(random, slots.back(), blocks);
}

// Compares a store with what was put into it.
void expect_holds(const BlockStore& blocks, const Slots& slots) {
  const std::vector<std::uint32_t> valid = present(slots);
  ASSERT_EQ(blocks.size(), slots.size());
  ASSERT_EQ(blocks.stored(), valid.size());
  ASSERT_EQ(blocks.invalid_count(), slots.size() - valid.size());
  ASSERT_LE(blocks.size(), blocks.capacity());
  ASSERT_EQ(std::vector<std::uint32_t>(planes_of(blocks).indices(), planes_of(blocks).indices() + blocks.stored()),
            valid);
  int rows = 0;
  Eigen::Matrix<double, 1, 6> largest = Eigen::Matrix<double, 1, 6>::Zero();
  for (std::size_t j = 0; j < valid.size(); ++j) {
    ASSERT_EQ(planes_of(blocks).place(valid[j]), j);
    rows = std::max(rows, static_cast<int>(slots[valid[j]]->rows()));
  }
  ASSERT_EQ(blocks.rows(), rows);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    ASSERT_EQ(blocks.is_valid(i), slots[i].has_value()) << i;
    ASSERT_EQ(planes_of(blocks).validity()[i], slots[i] ? 1 : 0);
    if (!slots[i]) continue;
    Block padded = Block::Zero(rows, 6);
    padded.topRows(slots[i]->rows()) = rounded(*slots[i]);
    ASSERT_EQ(stored_block(blocks, i), padded) << i;
    largest = largest.cwiseMax(padded.cwiseAbs().colwise().maxCoeff());
  }
  for (int column = 0; column < 6; ++column) ASSERT_EQ(planes_of(blocks).column_max()[column], largest(column));
}

// Appends the blocks of a random frame of any kind to both; some matches have none.
void append_matches(Random& random, BlockStore& blocks, Slots& slots) {
  const std::size_t n = random.index(41);
  sim::Frame frame = make_scene(sim::Scene::euroc_like, n, random.seed() + blocks.size());
  const std::vector<unsigned char> usable = spoil(random, random.uniform(0, 1), frame);
  const BlockKind& kind = block_kinds[random.index(std::size(block_kinds))];
  BlockStore alone;
  append(frame, usable, kind, alone);
  EXPECT_EQ(append(frame, usable, kind, blocks).invalid, alone.invalid_count());
  for (std::uint32_t i = 0; i < n; ++i) {
    slots.emplace_back();
    if (alone.is_valid(i)) slots.back() = stored_block(alone, i);
  }
}

// Changes a store, and the model in the same way.
void change(Random& random, BlockStore& blocks, Slots& slots) {
  switch (random.integer(0, 9)) {
    case 0: {
      const BlockStore copy = blocks;
      expect_holds(copy, slots);
      EXPECT_EQ(copy.capacity(), blocks.size());
      blocks = copy;
      break;
    }
    case 1: {
      BlockStore moved = std::move(blocks);
      expect_holds(moved, slots);
      expect_holds(blocks, {});  // NOLINT(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
      EXPECT_EQ(blocks.capacity(), 0U);
      blocks = std::move(moved);
      break;
    }
    case 2: blocks.reserve(blocks.size() + static_cast<std::size_t>(random.integer(0, 200))); break;
    case 3:
      if (!random.chance(0.2)) break;
      blocks.clear();
      slots.clear();
      break;
    case 4:
    case 5: append_matches(random, blocks, slots); break;
    default:
      for (int i = random.integer(1, 30); i > 0; --i) push_back_random(random, blocks, slots);
  }
}

TEST(EmptySlots, indices_and_places_are_right_after_any_change) {
  for_each_trial(100, [](Random& random) {
    BlockStore blocks;
    Slots slots;
    for (int step = 0; step < 40; ++step) {
      change(random, blocks, slots);
      expect_holds(blocks, slots);
    }
  });
}

TEST(EmptySlots, more_candidates_than_indices_are_refused) {
  constexpr std::size_t max_index = std::numeric_limits<std::uint32_t>::max();
  Random random;
  BlockStore blocks;
  const Block block = random_block(random, 2);
  push_back(blocks, block);
  for (const std::size_t capacity : {max_index + 1, 2 * max_index, std::numeric_limits<std::size_t>::max()}) {
    EXPECT_THROW(blocks.reserve(capacity), std::bad_alloc) << capacity;
    EXPECT_THROW(BlockStore{capacity}, std::bad_alloc) << capacity;
  }
  expect_holds(blocks, {block});
  EXPECT_EQ(blocks.capacity(), 64U);
}

}  // namespace
}  // namespace maxlogdet::test
