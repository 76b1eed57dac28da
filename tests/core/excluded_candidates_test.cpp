// SPDX-License-Identifier: MIT
// Excluded candidates and empty slots against a store that holds only the others: many excluded ones are as if they
// were not there, bit for bit, as empty slots are; few are passed over.
#include "kernel/blocks/block_planes.hpp"
#include "tests/core/slots.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace maxlogdet::test {
namespace {

// Candidates of which some are excluded, and the store of the others. The first is kept and has as many rows as any.
struct Excluded {
  BlockStore whole, dense;
  std::vector<std::uint32_t> kept;
  Request request;
};

// Excludes `excluded` valid candidates; a `share` of the slots is empty. Some excluded blocks are larger than all
// others.
Excluded random_excluded(Random& random, std::size_t n, std::size_t excluded, double share) {
  std::vector<Block> blocks = random_blocks(random, n);
  blocks[0] = random_block(random, 3);
  const Slots slots = with_empty_slots(random, blocks, share);
  std::vector<std::uint32_t> valid = present(slots);
  std::vector<unsigned char> flags(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) flags[i] = !slots[i] && random.chance(0.5) ? 1 : 0;
  for (std::size_t j = 0; j < excluded; ++j) {  // a partial shuffle of all but the first candidate
    std::swap(valid[j + 1], valid[j + 1 + random.index(n - 1 - j)]);
    flags[valid[j + 1]] = 5;
  }
  Excluded made;
  for (std::uint32_t i = 0; i < slots.size(); ++i) {
    const bool is_out = flags[i] != 0;
    push_back_slot(random, is_out && slots[i] ? std::optional<Block>(*slots[i] * random.uniform(0.1, 50)) : slots[i],
                   made.whole);
    if (is_out || !slots[i]) continue;
    push_back(made.dense, *slots[i]);
    made.kept.push_back(i);
  }
  made.request = random_request(random, made.whole);
  made.request.excluded = flags;
  for (std::size_t i = 0; i < flags.size() && !made.request.required.empty(); ++i) {
    if (flags[i] != 0) made.request.required[i] = 0;
  }
  return made;
}

// Or only empty slots.
TEST(ExcludedCandidates, many_are_as_if_they_were_not_there) {
  for_each_trial(1200, [](Random& random) {
    const bool are_excluded = random.chance(0.5);
    const std::size_t n = 2 + random.index(149);
    const std::size_t excluded = are_excluded ? n / 8 + 1 + random.index(n - 1 - n / 8) : 0;
    const double empty = are_excluded && random.chance(0.5) ? 0 : random.uniform(0.02, 0.9);
    Excluded problem = random_excluded(random, n, excluded, empty);
    if (!are_excluded) problem.request.excluded.clear();
    expect_same_answers(problem.whole, problem.request, problem.dense, problem.kept);
    expect_same_active(random, problem.whole, problem.request, problem.dense, problem.kept);
  });
}

// The others are pushed back one by one, so that their store does not know that they are factored.
TEST(ExcludedCandidates, many_of_a_frame_are_as_if_they_were_not_there) {
  for_every_family(1500, [](const BlockStore& blocks) {
    TracedRandom random;
    Request request = certified_request(20);
    BlockStore dense;
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < blocks.size(); ++i) {
      request.excluded.push_back(random.chance(0.4) ? 1 : 0);
      if (request.excluded[i] != 0) continue;
      push_back(dense, stored_block(blocks, i));
      kept.push_back(i);
    }
    expect_same_answers(blocks, request, dense, kept, false);
    request.plain.budget = kept.size() - 10;
    expect_same_answers(blocks, request, dense, kept, false);
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
      Request request = certified_request(20);
      expect_same_answers(holed, request, dense, kept);
      request.plain.budget = kept.size() - 10;
      expect_same_answers(holed, request, dense, kept);
    }
  }
}

// Too few for a copy without them, they are skipped. Sums in float64 then contain other zeros, which changes the last
// digits of a bound, and the relaxation starts from another sample.
TEST(ExcludedCandidates, few_are_never_selected_and_change_no_gain) {
  for_each_trial(600, [](Random& random) {
    const std::size_t n = 8 + random.index(143);
    const Excluded problem = random_excluded(random, n, 1 + random.index(n / 8), random.chance(0.5) ? 0.3 : 0);
    const Request of_dense = request_of(problem.request, problem.kept);
    Selector selector = selector_for(problem.whole, problem.request);
    Selector dense_selector = selector_for(problem.dense, of_dense);
    for (const Strategy strategy : strategies) {
      if (strategy == Strategy::relaxed) continue;
      SCOPED_TRACE(to_string(strategy));
      const Selection expected = dense_selector.select(problem.dense, of_dense.options(strategy));
      const Selection actual = selector.select(problem.whole, problem.request.options(strategy));
      EXPECT_STREQ(actual.reason(), expected.reason());
      ASSERT_EQ(indices_of(actual), gathered(problem.kept, indices_of(expected)));
      for (std::size_t j = 0; j < actual.size; ++j) EXPECT_EQ(bits_of(actual.gains[j]), bits_of(expected.gains[j]));
      EXPECT_EQ(bits_of(actual.log_det), bits_of(expected.log_det));
      EXPECT_EQ(std::isnan(actual.upper_bound), std::isnan(expected.upper_bound));
      if (std::isnan(expected.upper_bound)) continue;
      EXPECT_NEAR(actual.upper_bound, expected.upper_bound, 1e-6 * (1 + std::abs(expected.upper_bound)));
    }
    expect_same_active(random, problem.whole, problem.request, problem.dense, problem.kept);
  });
}

TEST(ExcludedCandidates, all_of_them_leave_nothing_as_empty_slots_alone_do) {
  for (const std::size_t n : {std::size_t{1}, std::size_t{7}, std::size_t{16}, std::size_t{400}, std::size_t{1000}}) {
    for (const bool are_empty : {false, true}) {
      TracedRandom random(n);
      BlockStore blocks = store_of(random, with_empty_slots(random, random_blocks(random, n), 0.3));
      Request request = certified_request(5);
      request.excluded.assign(blocks.size(), 1);
      if (are_empty) {
        blocks.clear();
        for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(push_back_empty(random, blocks), i);
        EXPECT_EQ(blocks.stored(), 0U);
        EXPECT_EQ(blocks.rows(), 0);
        request.excluded = n > 1 ? random_flags(random, n, 0.5) : std::vector<unsigned char>();
      }
      expect_same_answers(blocks, request, BlockStore(), {});
      ActiveSelection active(std::max<std::size_t>(5, blocks.size()));
      ASSERT_EQ(active.start(blocks, request.options(Strategy::lazy_greedy)), Error::none);
      EXPECT_EQ(active.next(), ActiveSelection::none);
      EXPECT_EQ(active.selection().status, Status::all_selected);
      request.required.resize(blocks.size());
      request.required[n / 2] = 1;
      Selector selector = selector_for(blocks, request);
      EXPECT_EQ(selector.select(blocks, request.options(Strategy::greedy)).error, Error::infeasible);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
