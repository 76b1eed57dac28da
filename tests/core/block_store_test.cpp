// SPDX-License-Identifier: MIT
// A store of candidates by hand, against a model that is a list of blocks after any change, and its empty slots: an
// answer is that of a store without them.
#include "kernel/blocks/block_planes.hpp"
#include "tests/core/slots.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <new>
#include <utility>

namespace maxlogdet::test {
namespace {

void expect_holds(const BlockStore& blocks, std::size_t i, const Block& expected) {
  Block padded = Block::Zero(blocks.rows(), 6);
  padded.topRows(expected.rows()) = rounded(expected);
  EXPECT_EQ(stored_block(blocks, i), padded) << "candidate " << i;
}

TEST(BlockStore, planes_are_aligned_to_64_bytes) {
  for (const std::size_t capacity : {1U, 15U, 16U, 17U, 1000U, 2048U}) {
    const BlockStore blocks(capacity);
    EXPECT_EQ(blocks.capacity(), capacity);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 6; ++column) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(planes_of(blocks).plane(row, column)) % 64, 0U);
      }
    }
  }
}

TEST(BlockStore, grows_keeps_and_clears) {
  Random random;
  BlockStore blocks(2);
  const Block first = random_block(random, 2);
  push_back(blocks, first);
  blocks.reserve(1000);
  EXPECT_EQ(blocks.capacity(), 1000U);
  blocks.reserve(10);
  EXPECT_EQ(blocks.capacity(), 1000U) << "never shrinks";
  expect_holds(blocks, 0, first);
  blocks.push_back_invalid();
  push_back(blocks, first);
  blocks.reserve(5000);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(blocks.is_valid(i), i != 1) << "after growing";
  blocks.clear();
  EXPECT_EQ(blocks.size(), 0U);
  EXPECT_EQ(blocks.rows(), 0);
  EXPECT_EQ(blocks.invalid_count(), 0U);
  for (int column = 0; column < 6; ++column) EXPECT_EQ(planes_of(blocks).column_max()[column], 0);
  EXPECT_EQ(blocks.capacity(), 5000U);
  const Block tall = random_block(random, 3);
  push_back(blocks, first);
  push_back(blocks, tall);
  expect_holds(blocks, 0, first);
  expect_holds(blocks, 1, tall);
}

TEST(BlockStore, keeps_what_it_cannot_hold_as_invalid_at_its_index) {
  BlockStore blocks;
  const double good[18] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18};
  double bad[18];
  std::copy(good, good + 18, bad);
  bad[11] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(blocks.push_back(good, 2), 0U);
  EXPECT_EQ(blocks.push_back(bad, 2), 1U);
  EXPECT_EQ(blocks.push_back(bad, 1), 2U) << "the NaN is beyond its one row";
  EXPECT_EQ(blocks.push_back(good, 0), 3U);
  EXPECT_EQ(blocks.push_back(good, 4), 4U);
  EXPECT_EQ(blocks.push_back(good, -1), 5U);
  EXPECT_EQ(blocks.push_back(nullptr, 2), 6U);
  EXPECT_EQ(blocks.push_back_invalid(), 7U);
  bad[11] = 3.5e38;
  EXPECT_EQ(blocks.push_back(bad, 2), 8U);
  bad[11] = 3.4e38;
  EXPECT_EQ(blocks.push_back(bad, 2), 9U);
  const bool expected[] = {true, false, true, false, false, false, false, false, false, true};
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(blocks.is_valid(i), expected[i]) << i;
  EXPECT_EQ(blocks.invalid_count(), 7U);
  EXPECT_EQ(blocks.rows(), 2);
}

TEST(BlockStore, copies_are_independent_and_moves_leave_an_empty_store) {
  Random random;
  BlockStore blocks = awkward_blocks(random, 50);
  blocks.push_back_invalid();
  const BlockStore copy = blocks;
  const Block kept = stored_block(blocks, 7);
  blocks.clear();
  push_back(blocks, random_block(random, 1));
  ASSERT_EQ(copy.size(), 51U);
  EXPECT_EQ(stored_block(copy, 7), kept);
  EXPECT_EQ(copy.invalid_count(), 1U);
  EXPECT_FALSE(copy.is_valid(50));

  BlockStore assigned(3);
  assigned = copy;
  const BlockStore& self = assigned;
  assigned = self;
  EXPECT_EQ(stored_block(assigned, 7), kept);
  BlockStore moved = std::move(assigned);
  EXPECT_EQ(stored_block(moved, 7), kept);
  EXPECT_EQ(assigned.size(), 0U);  // NOLINT(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  EXPECT_EQ(assigned.capacity(), 0U);
  push_back(assigned, kept);
  expect_holds(assigned, 0, kept);
  moved = std::move(assigned);
  EXPECT_EQ(moved.size(), 1U);
}

TEST(BlockStore, reads_a_block_as_stored) {
  Random random;
  BlockStore blocks;
  const Block pushed[] = {random_block(random, 1), random_block(random, 2)};
  push_back(blocks, pushed[0]);
  blocks.push_back_invalid();
  push_back(blocks, pushed[1]);
  double entries[max_block_rows * state_dimension];
  std::fill(std::begin(entries), std::end(entries), 7.0);
  EXPECT_EQ(blocks.block(1, entries), 0);
  EXPECT_EQ(blocks.block(3, entries), 0);
  EXPECT_FALSE(blocks.is_valid(3));
  for (const double entry : entries) EXPECT_EQ(entry, 7) << "written to";
  for (const std::size_t i : {0U, 2U}) {
    ASSERT_EQ(blocks.block(i, entries), 2);
    Block expected = Block::Zero(2, 6);
    expected.topRows(pushed[i / 2].rows()) = rounded(pushed[i / 2]);
    EXPECT_EQ(Eigen::Map<const Block>(entries, 2, 6), expected) << i;
    EXPECT_EQ(entries[12], 7) << "written beyond its rows";
  }
}

// Each in turn, as the first call after the move.
TEST(BlockStore, takes_any_call_once_moved_from) {
  Random random;
  const Block block = random_block(random, 2);
  const auto after_a_move = [&](const auto& call) {
    BlockStore blocks = store_of({block});
    const BlockStore moved = std::move(blocks);
    EXPECT_EQ(moved.size(), 1U);
    call(blocks);  // NOLINT(bugprone-use-after-move)
    EXPECT_EQ(blocks.size(), blocks.stored() + blocks.invalid_count());
    blocks.clear();
    push_back(blocks, block);
    expect_holds(blocks, 0, block);
  };
  after_a_move([](BlockStore& blocks) {
    double entries[max_block_rows * state_dimension];
    EXPECT_EQ(blocks.size() + blocks.capacity() + blocks.stored() + blocks.invalid_count(), 0U);
    EXPECT_EQ(blocks.rows(), 0);
    EXPECT_FALSE(blocks.is_valid(0));
    EXPECT_EQ(blocks.block(0, entries), 0);
  });
  after_a_move([](BlockStore& blocks) { blocks.reserve(0); });
  after_a_move([](BlockStore& blocks) {
    EXPECT_THROW(blocks.reserve(std::numeric_limits<std::size_t>::max()), std::bad_alloc);
    EXPECT_EQ(blocks.capacity(), 0U);
  });
  after_a_move([](BlockStore& blocks) { EXPECT_EQ(blocks.push_back_invalid(), 0U); });
  after_a_move([](BlockStore& blocks) {
    BlockStore copy = blocks;
    BlockStore moved = std::move(blocks);
    EXPECT_EQ(copy.size() + moved.size(), 0U);
    moved = copy;
    blocks = std::move(moved);
    blocks = copy;
    EXPECT_EQ(blocks.size(), 0U);
  });
  after_a_move([](BlockStore& blocks) {
    Selector selector(1);
    EXPECT_EQ(selector.select(blocks, with_budget(1)).status, Status::ok);
  });
  after_a_move([](BlockStore& blocks) {
    const double p_w[] = {0.1, 0.2, 3};
    Matches matches;
    matches.points = Points(p_w);
    matches.size = 1;
    EXPECT_EQ(
        append_blocks(Camera(500, 500, 320, 240), RigidTransform::identity(), matches, BlockOptions(), blocks).invalid,
        0U);
    EXPECT_EQ(blocks.stored(), 1U);
  });
}

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

// Empty slots are as if they were not there.
TEST(EmptySlots, answers_are_those_of_a_store_without_them) {
  for_each_trial(600, [](Random& random) {
    const std::vector<Block> blocks = random_blocks(random, 1 + random.index(150));
    const Slots slots = with_empty_slots(random, blocks, random.uniform(0.02, 0.9));
    const BlockStore whole = store_of(random, slots);
    expect_same_answers(whole, random_request(random, whole), store_of(blocks), present(slots));
  });
}

TEST(EmptySlots, answers_are_those_of_the_frame_without_them) {
  for (const sim::Scene scene : sim::scenes) {
    for (const BlockKind& kind : block_kinds) {
      Random random(static_cast<std::uint64_t>(scene));
      SCOPED_TRACE(random.name() + ", " + to_string(scene) + ' ' + kind.name);
      sim::Frame frame = make_scene(scene, 1500, random.seed());
      const std::vector<unsigned char> usable = spoil(random, random.uniform(0.05, 0.8), frame);
      BlockStore holed;
      append(frame, usable, kind, holed);
      const std::vector<std::uint32_t> kept(planes_of(holed).indices(), planes_of(holed).indices() + holed.stored());
      ASSERT_GT(kept.size(), 200U);
      ASSERT_LT(kept.size(), 1500U);
      BlockOptions options;
      options.weighting = kind.weighting;
      options.depth_cue = kind.depth_cue;
      BlockStore dense;
      sim::build_blocks(frame, sim::MatchArrays(frame, kept), options, dense);
      ASSERT_EQ(dense.stored(), kept.size());
      Request request;
      request.plain.certificate = true;
      for (const std::size_t budget : {std::size_t{20}, kept.size() - 10}) {
        request.plain.budget = budget;
        expect_same_answers(holed, request, dense, kept);
      }
    }
  }
}

TEST(EmptySlots, alone_they_leave_nothing) {
  for (const std::size_t n : {std::size_t{1}, std::size_t{16}, std::size_t{1000}}) {
    TracedRandom random(n);
    BlockStore blocks;
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(push_back_empty(random, blocks), i);
    EXPECT_EQ(blocks.stored(), 0U);
    EXPECT_EQ(blocks.rows(), 0);
    Request request;
    request.plain.budget = 5;
    request.plain.certificate = true;
    expect_same_answers(blocks, request, BlockStore(), {});
    request.required.resize(n);
    request.required[n / 2] = 1;
    Selector selector(n + 5);
    EXPECT_EQ(selector.select(blocks, request.options()).error, Error::infeasible);
  }
}

TEST(EigenAdapter, takes_blocks_of_any_scalar_and_storage_order) {
  Random random;
  const Block block = rounded(random_block(random, 2));
  BlockStore blocks;
  push_back(blocks, block);
  push_back(blocks, block.cast<float>());
  const Eigen::Matrix<double, 2, 6> fixed = block;
  push_back(blocks, fixed);
  const Eigen::MatrixXd dynamic = block;
  push_back(blocks, dynamic);
  push_back(blocks, 2 * dynamic - dynamic);  // an expression
  for (std::size_t i = 0; i < blocks.size(); ++i) EXPECT_EQ(stored_block(blocks, i), block) << i;
  push_back(blocks, Eigen::MatrixXd::Zero(4, 6).eval());
  push_back(blocks, Eigen::MatrixXd::Zero(2, 5).eval());
  push_back(blocks, Eigen::MatrixXd::Zero(0, 6).eval());
  EXPECT_EQ(blocks.invalid_count(), 3U);
}

TEST(EigenAdapter, passes_a_prior) {
  Random random;
  const Matrix6 information = random_prior(random);
  const EigenPrior prior(information);
  Options options;
  options.budget = 0;
  options.prior = prior.data();
  Selector selector(1);
  const double log_det = selector.select(BlockStore(), options).log_det;
  EXPECT_NEAR(log_det, 2 * information.llt().matrixLLT().diagonal().array().log().sum(), 1e-12);
}

}  // namespace
}  // namespace maxlogdet::test
