// SPDX-License-Identifier: MIT
// Stores of blocks against a model that is a list of blocks, after any change; batches of matches, some of them broken,
// by every instruction set and one by one. That the equations of blocks are right is shown by blocks_test.cpp.
#include "tests/core/feature_frame.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// Matches of any kind, in half of the frames with some that are odd: broken covariances, and points that are very
// far away. The others hold whole packs of valid matches.
FeatureFrame random_frame(Random& random, std::size_t n, DepthCue depth_cue) {
  const bool is_pinhole = depth_cue == DepthCue::stereo || random.chance(0.5);
  const FeatureKind kind = {is_pinhole ? CameraModel::pinhole : random_model(random), depth_cue, random.chance(0.5),
                            FeatureKind::Covariances(random.integer(0, 2))};
  FeatureFrame frame(random, n, kind);
  if (random.chance(0.5)) return frame;
  frame.make_odd(random, 0.2);
  for (std::size_t i = 0; i < n; ++i) {
    if (random.chance(0.1)) frame.covariances[9 * i] = random.chance(0.5) ? nan : -1e6;  // not definite
    if (random.chance(0.1)) frame.covariances[9 * i + 8] *= std::pow(10, random.uniform(0, 16));
    if (random.chance(0.05)) frame.matches[i].point[2] *= 1e150;
  }
  return frame;
}

FeatureFrame any_frame(Random& random, std::size_t n) { return random_frame(random, n, thirds[random.integer(0, 2)]); }

// All lengths of the last pack, behind some candidates; an unknown MAXLOGDET_ISA is as none.
TEST(BlockBuilding, gives_the_same_bits_on_every_instruction_set) {
  for (const DepthCue depth_cue : thirds) {
    for (std::size_t variation = 0; variation < 4 * 71; ++variation) {
      const std::size_t n = variation % 71;
      Random random(variation);
      SCOPED_TRACE(random.name() + ", " + std::to_string(n) + " matches, " + name_of(depth_cue));
      const FeatureFrame frame = random_frame(random, n, depth_cue);
      const std::vector<FeatureMatch> matches = frame.records();
      const std::vector<Block> before(random.index(6), random_block(random, random.integer(1, 3)));
      std::optional<BlockReport> first;
      const auto build = [&] {
        BlockStore blocks(before.size() + n);  // a plane may end with the last match
        for (const Block& block : before) push_back(blocks, block);
        const BlockReport report = frame.append(matches, blocks);
        EXPECT_EQ(report.error, Error::none) << to_string(report.error);
        EXPECT_EQ(report.appended, n);
        EXPECT_EQ(report.invalid, blocks.size() - blocks.stored());
        if (!first) first = report;
        expect_same(report, *first);
        return bytes_of(blocks);
      };
      const std::vector<unsigned char> expected = same_on_every_isa(build);
      const ForcedIsa forced("none of these");
      EXPECT_EQ(build(), expected);
      if (::testing::Test::HasFailure()) return;  // one is enough to look at
    }
  }
}

// And its report is the sum of theirs, its rows those of the valid block with most of them. A match alone has the
// covariance that it has among others, and behind it one that shows which cue the frame has.
TEST(BlockBuilding, gives_each_match_what_it_gets_alone) {
  for_each_trial(300, [&](Random& random) {
    const FeatureFrame frame = any_frame(random, random.index(random.chance(0.3) ? 5 : 150));
    const std::vector<FeatureMatch> matches = frame.records();
    BlockStore together(1), of_cue(1);
    const BlockReport report = frame.append(matches, together);
    BlockReport sum;
    int rows = 0;
    const double variance = frame.options.map_sigma * frame.options.map_sigma;
    const double unknown[9] = {variance, 0, 0, 0, variance, 0, 0, 0, variance};
    std::vector<FeatureMatch> with_cue;
    for (std::size_t i = 0; i < matches.size() && with_cue.empty(); ++i) {
      if (frame.usable[i] != 0 && frame.has_depth_cue[i] != 0) with_cue = {matches[i]};
    }
    const BlockReport counted_twice = frame.append(with_cue, of_cue);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      BlockStore own(1);
      std::vector<FeatureMatch> alone = {matches[i]};
      if (frame.has_covariances() && frame.knows_covariance[i] == 0) alone[0].covariance = unknown;
      alone.insert(alone.end(), with_cue.begin(), with_cue.end());
      const BlockReport one = frame.append(alone, own);
      for (const auto& count : counts_of_report) sum.*count += one.*count - counted_twice.*count;
      rows = std::max(rows, own.rows());
      ASSERT_EQ(own.is_valid(0), together.is_valid(i)) << i;
      if (!own.is_valid(0)) continue;
      const Block expected = stored_block(own, 0);
      ASSERT_EQ(stored_block(together, i).topRows(expected.rows()), expected) << i;
      ASSERT_TRUE((stored_block(together, i).bottomRows(together.rows() - expected.rows()).array() == 0).all());
    }
    EXPECT_EQ(together.rows(), rows);
    expect_same(report, sum);
  });
}

// Blocks in the order of their indices, as stored; an invalid candidate has none.
using Slots = std::vector<std::optional<Block>>;

// Appends a block, some of which have an entry that float32 cannot hold, or just can. What follows the rows of a block
// is not read.
void push_back_block(Random& random, BlockStore& blocks, Slots& slots) {
  constexpr double halfway = 0x1p128 - 0x1p103;  // from the largest float32 to 2^128: rounds up
  constexpr double smallest = 0x1p-149;
  const double ends[] = {nan, infinity, 1e39, -1e300, halfway, std::nextafter(halfway, 0), smallest, smallest / 2};
  Block block = random_block(random, random.integer(1, 3));
  if (random.chance(0.3))
    block(random.integer(0, static_cast<int>(block.rows()) - 1), random.integer(0, 5)) = ends[random.integer(0, 7)];
  double entries[18];
  std::fill(std::copy_n(block.data(), block.size(), entries), std::end(entries), nan);
  EXPECT_EQ(blocks.push_back(entries, static_cast<int>(block.rows())), slots.size());
  slots.emplace_back();
  if ((block.array().abs() < halfway).all()) slots.back() = rounded(block);
}

// Appends a candidate without a block, in any of the ways that there are.
void push_back_hole(Random& random, BlockStore& blocks) {
  const double entries[24] = {};
  const int rows[] = {-1, 0, 4};
  const std::size_t index = blocks.size();
  const int way = random.integer(0, 4);
  EXPECT_EQ(way < 3    ? blocks.push_back(entries, rows[way])
            : way == 3 ? blocks.push_back(nullptr, 2)
                       : blocks.push_back_invalid(),
            index);
}

// Appends a batch of matches; a store of its own says which blocks they have.
void append_batch(Random& random, BlockStore& blocks, Slots& slots) {
  const FeatureFrame frame = any_frame(random, random.index(41));
  const std::vector<FeatureMatch> matches = frame.records();
  BlockStore alone;
  expect_same(frame.append(matches, blocks), frame.append(matches, alone));
  for (std::size_t i = 0; i < alone.size(); ++i) {
    slots.emplace_back();
    if (alone.is_valid(i)) slots.back() = stored_block(alone, i);
  }
}

// block() writes the block as stored, and nothing beyond its rows.
void expect_written(const BlockStore& blocks, std::size_t i, int rows) {
  double entries[18];
  std::fill(std::begin(entries), std::end(entries), -7.0);
  ASSERT_EQ(blocks.block(i, entries), rows);
  for (const double* entry = entries + 6 * rows; entry != std::end(entries); ++entry) ASSERT_EQ(*entry, -7);
}

// Compares a store with what was put into it.
void expect_holds(const BlockStore& blocks, const Slots& slots) {
  std::size_t stored = 0;
  int rows = 0;
  Eigen::Matrix<double, 1, 6> largest = Eigen::Matrix<double, 1, 6>::Zero();
  for (const auto& slot : slots) rows = std::max(rows, slot ? static_cast<int>(slot->rows()) : 0);
  ASSERT_EQ(blocks.size(), slots.size());
  ASSERT_LE(blocks.size(), blocks.capacity());
  ASSERT_EQ(blocks.rows(), rows);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    ASSERT_EQ(blocks.is_valid(i), slots[i].has_value()) << i;
    ASSERT_EQ(blocks.validity()[i], slots[i] ? 1 : 0);
    ASSERT_NO_FATAL_FAILURE(expect_written(blocks, i, slots[i] ? rows : 0));
    Block padded = Block::Zero(rows, 6);
    if (slots[i]) padded.topRows(slots[i]->rows()) = *slots[i];
    for (int e = 0; e < 6 * rows; ++e)
      ASSERT_EQ(double{blocks.planes()[static_cast<std::size_t>(e) * blocks.stride() + i]}, padded(e / 6, e % 6)) << i;
    if (!slots[i]) continue;
    ++stored;
    ASSERT_EQ(stored_block(blocks, i), padded) << i;
    largest = largest.cwiseMax(padded.cwiseAbs().colwise().maxCoeff());
  }
  ASSERT_EQ(blocks.stored(), stored);
  ASSERT_FALSE(blocks.is_valid(slots.size()));
  ASSERT_NO_FATAL_FAILURE(expect_written(blocks, slots.size(), 0));
  for (int column = 0; column < 6; ++column) ASSERT_EQ(blocks.column_max()[column], largest(column));
  ASSERT_EQ(reinterpret_cast<std::uintptr_t>(blocks.planes()) % 64, 0U);
  ASSERT_EQ(blocks.stride() % 16, 0U);
}

// Changes a store, and the model in the same way.
void change(Random& random, BlockStore& blocks, Slots& slots) {
  switch (random.integer(0, 9)) {
    case 0: {
      const BlockStore copy = blocks;
      push_back(blocks, random_block(random, 3));
      expect_holds(copy, slots);  // on its own
      EXPECT_EQ(copy.capacity(), slots.size());
      blocks = copy;
      const BlockStore& self = blocks;
      blocks = self;
      break;
    }
    case 1: {
      BlockStore moved = std::move(blocks);
      expect_holds(moved, slots);
      expect_holds(blocks, {});  // NOLINT(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
      EXPECT_EQ(blocks.capacity(), 0U);
      EXPECT_EQ(select_indices(blocks, with_budget(1)).size(), 0U);
      if (random.chance(0.5)) {
        slots.clear();  // the next change is that of a store moved from
      } else {
        blocks = std::move(moved);
      }
      break;
    }
    case 2: {
      const std::size_t before = blocks.capacity(), asked = random.index(blocks.size() + 200);
      blocks.reserve(asked);
      EXPECT_EQ(blocks.capacity(), std::max(before, asked)) << "it never shrinks";
      break;
    }
    case 3:
      if (!random.chance(0.2)) break;
      blocks.clear();
      slots.clear();
      break;
    case 4:
    case 5: append_batch(random, blocks, slots); break;
    default:
      for (int i = random.integer(1, 30); i > 0; --i) {
        if (random.chance(0.6)) {
          push_back_block(random, blocks, slots);
        } else {
          push_back_hole(random, blocks);
          slots.emplace_back();
        }
      }
  }
}

TEST(BlockStore, holds_what_was_put_into_it_after_any_change) {
  for_each_trial(100, [](Random& random) {
    BlockStore blocks;
    Slots slots;
    for (int step = 0; step < 40; ++step) {
      change(random, blocks, slots);
      expect_holds(blocks, slots);
    }
  });
}

// Of a store that holds a block, and of one that was moved from.
TEST(BlockStore, more_candidates_than_indices_are_refused) {
  constexpr std::size_t max_index = std::numeric_limits<std::uint32_t>::max();
  BlockStore blocks = copies_of(Block::Ones(2, 6), 1), empty;
  const BlockStore moved = std::move(empty);
  for (const std::size_t capacity : {max_index + 1, 2 * max_index, std::numeric_limits<std::size_t>::max()}) {
    EXPECT_THROW(blocks.reserve(capacity), std::bad_alloc) << capacity;
    EXPECT_THROW(empty.reserve(capacity), std::bad_alloc);  // NOLINT(bugprone-use-after-move)
    EXPECT_THROW(BlockStore{capacity}, std::bad_alloc) << capacity;
  }
  EXPECT_EQ(stored_block(blocks, 0), Block::Ones(2, 6));
  EXPECT_EQ(blocks.capacity(), 64U);
  EXPECT_EQ(empty.capacity(), 0U);
}

TEST(EigenAdapter, takes_blocks_of_any_scalar_and_storage_order) {
  const Eigen::Matrix<double, 2, 6> fixed = Block::Ones(2, 6) / 4 + Block::Identity(2, 6);
  const Eigen::MatrixXd dynamic = fixed;
  BlockStore blocks;
  push_back(blocks, Block(fixed));
  push_back(blocks, fixed.cast<float>());
  push_back(blocks, fixed);
  push_back(blocks, dynamic);
  push_back(blocks, 2 * dynamic - dynamic);  // an expression
  for (std::size_t i = 0; i < blocks.size(); ++i) EXPECT_EQ(stored_block(blocks, i), fixed) << i;
  for (const auto& [rows, columns] : {std::pair(4, 6), std::pair(2, 5), std::pair(0, 6)}) {
    push_back(blocks, Eigen::MatrixXd::Zero(rows, columns).eval());
  }
  EXPECT_EQ(blocks.size() - blocks.stored(), 3U);
}

}  // namespace
}  // namespace maxlogdet::test
