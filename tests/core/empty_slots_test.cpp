// SPDX-License-Identifier: MIT
// Empty slots: a store with them against a model that is a list of blocks, after any change; and its answers against
// those of a store without them.
#include "bench/world/frame.hpp"
#include "kernel/blocks/block_planes.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// Blocks in the order of their indices; an invalid candidate has none.
using Slots = std::vector<std::optional<Block>>;

// 1 to 3 rows each; some duplicated, scaled, zero or nearly parallel to others.
std::vector<Block> random_blocks(Random& random, std::size_t n) {
  const BlockStore made = awkward_blocks(random, n);
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < n; ++i) {
    const Block padded = stored_block(made, i);
    Eigen::Index rows = padded.rows();
    while (rows > 1 && padded.row(rows - 1).isZero(0)) --rows;
    blocks.emplace_back(padded.topRows(rows));
  }
  return blocks;
}

// The same blocks with empty slots before, between and behind them.
Slots with_empty_slots(Random& random, const std::vector<Block>& blocks, double share) {
  Slots slots;
  for (const Block& block : blocks) {
    while (random.chance(share)) slots.emplace_back();
    slots.emplace_back(block);
  }
  while (random.chance(share)) slots.emplace_back();
  return slots;
}

// Appends a candidate without a block, in any of the ways that there are.
std::size_t push_back_empty(Random& random, BlockStore& blocks) {
  double entries[24] = {};
  const double broken[] = {nan, infinity, 1e39, -1e300};
  const int none[] = {-1, 0, 4};
  switch (random.integer(0, 3)) {
    case 0: {
      const int rows = random.integer(1, 3);
      entries[random.integer(0, 6 * rows - 1)] = broken[random.integer(0, 3)];
      return blocks.push_back(entries, rows);
    }
    case 1: return blocks.push_back(nullptr, 2);
    case 2: return blocks.push_back(entries, none[random.integer(0, 2)]);
    default: return blocks.push_back_invalid();
  }
}

// What follows the rows of a block is not read.
void push_back_slot(Random& random, const std::optional<Block>& slot, BlockStore& blocks) {
  const std::size_t index = blocks.size();
  if (!slot) {
    EXPECT_EQ(push_back_empty(random, blocks), index);
    return;
  }
  double entries[18];
  std::fill(std::copy_n(slot->data(), slot->size(), entries), std::end(entries), nan);
  EXPECT_EQ(blocks.push_back(entries, static_cast<int>(slot->rows())), index);
}

BlockStore store_with(Random& random, const Slots& slots) {
  BlockStore blocks;
  for (const std::optional<Block>& slot : slots) push_back_slot(random, slot, blocks);
  return blocks;
}

// Indices of the slots that have a block.
std::vector<std::uint32_t> present(const Slots& slots) {
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < slots.size(); ++i) {
    if (slots[i]) indices.push_back(i);
  }
  return indices;
}

template <class T>
std::vector<T> gathered(const std::vector<T>& values, const std::vector<std::uint32_t>& indices) {
  std::vector<T> result;
  if (values.empty()) return result;
  for (const std::uint32_t i : indices) result.push_back(values[i]);
  return result;
}

// The same request for a store that holds these candidates alone.
Request request_of(const Request& request, const std::vector<std::uint32_t>& indices) {
  Request result = request;
  result.required = gathered(request.required, indices);
  result.groups = gathered(request.groups, indices);
  return result;
}

// Any subset of the constraints, perhaps with a certificate, for some of the blocks.
Request random_request(Random& random, const BlockStore& blocks) {
  Problem problem = problem_of(blocks, 0);
  constrain(random, problem, random.chance(0.3));
  if (random.chance(0.5)) problem.set_prior(random_prior(random));
  const std::size_t required = problem.required_count();
  problem.plain.budget = required + random.index(blocks.stored() - required + 3);
  problem.plain.stochastic.seed = random.seed();
  problem.plain.stochastic.epsilon = random.uniform(0.01, 0.9);
  problem.plain.certificate = random.chance(0.5);
  return static_cast<const Request&>(problem);
}

// How a selection ended: an empty store gives ok, one whose candidates are all invalid all_selected.
void expect_same_end(const Selection& actual, const Selection& expected, bool has_candidates, std::size_t budget) {
  const bool differ = !has_candidates && budget > 0 && expected.status == Status::ok;
  EXPECT_EQ(actual.status, differ ? Status::all_selected : expected.status);
}

// The same but for indices, of which `kept` says what they are in the store with more candidates.
void expect_same_answer(const Selection& actual, const Selection& expected, const std::vector<std::uint32_t>& kept) {
  EXPECT_EQ(indices_of(actual), gathered(kept, indices_of(expected)));
  EXPECT_EQ(Answer(actual).numbers, Answer(expected).numbers);
  EXPECT_EQ(actual.threads, expected.threads);
}

// Every strategy's answer for `whole` against that for `dense`, which holds the candidates `kept` of it alone.
void expect_same_answers(const BlockStore& whole, const Request& request, const BlockStore& dense,
                         const std::vector<std::uint32_t>& kept) {
  const Request of_dense = request_of(request, kept);
  Selector selector(std::max(whole.size(), request.plain.budget));
  Selector dense_selector(std::max(dense.size(), request.plain.budget));
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const Selection expected = dense_selector.select(dense, of_dense.options(strategy));
    const Selection actual = selector.select(whole, request.options(strategy));
    expect_same_end(actual, expected, dense.size() > 0, request.plain.budget);
    expect_same_answer(actual, expected, kept);
    EXPECT_EQ(actual.evaluations, expected.evaluations);
    EXPECT_EQ(actual.float64_decisions, expected.float64_decisions);
    EXPECT_EQ(actual.invalid_candidates, whole.invalid_count());
  }
}

// To the other side of the camera.
void mirror(const std::array<double, 12>& T_cw, double* point) {
  for (std::size_t d = 0; d < 3; ++d) {
    const double camera = -(T_cw[d] * T_cw[3] + T_cw[4 + d] * T_cw[7] + T_cw[8 + d] * T_cw[11]);
    point[d] = 2 * camera - point[d];
  }
}

// Leaves some matches without a block, for every reason that there is; returns which are usable.
std::vector<unsigned char> spoil(Random& random, double share, sim::Frame& frame) {
  std::vector<unsigned char> usable(frame.matches.size(), 1);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    if (!random.chance(share)) continue;
    sim::Match& match = frame.matches[i];
    switch (random.integer(0, 3)) {
      case 0: match.point[random.integer(0, 2)] = nan; break;
      case 1: match.inv_sigma2 = random.chance(0.5) ? nan : -1; break;
      case 2: mirror(frame.T_cw_prior, match.point); break;
      default: usable[i] = 0;
    }
  }
  return usable;
}

// Appends the blocks of a frame's usable matches.
BlockReport append(const sim::Frame& frame, const std::vector<unsigned char>& usable, const BlockKind& kind,
                   BlockStore& blocks) {
  const sim::MatchArrays arrays(frame);
  Matches matches = arrays.view();
  matches.usable = usable.data();
  BlockOptions options;
  options.weighting = kind.weighting;
  options.depth_cue = kind.depth_cue;
  const RigidTransform T_cw = RigidTransform::row_major(frame.T_cw_prior.data());
  return append_blocks(frame.camera, T_cw, matches, options, blocks);
}

// Appends a slot, with a block or without.
void push_back_random(Random& random, BlockStore& blocks, Slots& slots) {
  slots.emplace_back();
  if (random.chance(0.5)) slots.back() = random_block(random, random.integer(1, 3));
  push_back_slot(random, slots.back(), blocks);
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
    ASSERT_NO_FATAL_FAILURE(expect_written(blocks, i, slots[i] ? rows : 0));
    if (!slots[i]) continue;
    Block padded = Block::Zero(rows, 6);
    padded.topRows(slots[i]->rows()) = rounded(*slots[i]);
    ASSERT_EQ(stored_block(blocks, i), padded) << i;
    largest = largest.cwiseMax(padded.cwiseAbs().colwise().maxCoeff());
  }
  ASSERT_FALSE(blocks.is_valid(slots.size()));
  ASSERT_NO_FATAL_FAILURE(expect_written(blocks, slots.size(), 0));
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

// Empty slots are as if they were not there.
TEST(EmptySlots, answers_are_those_of_a_store_without_them) {
  for_each_trial(600, [](Random& random) {
    const std::vector<Block> blocks = random_blocks(random, 1 + random.index(150));
    const Slots slots = with_empty_slots(random, blocks, random.uniform(0.02, 0.9));
    const BlockStore whole = store_with(random, slots);
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
    for (std::size_t i = 0; i < n; ++i) push_back_empty(random, blocks);
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

}  // namespace
}  // namespace maxlogdet::test
