// SPDX-License-Identifier: MIT
// Candidates without a block take an index and nothing else: the answer is that of a store that holds only the others,
// bit for bit, whatever is asked for.
#include "kernel/blocks/block_planes.hpp"
#include "tests/core/slots.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

namespace maxlogdet::test {
namespace {

TEST(EmptySlots, answers_are_those_of_the_store_without_them) {
  for_each_trial(600, [](Random& random) {
    const std::vector<Block> blocks = random_blocks(random, random.index(151));
    const Slots slots = with_empty_slots(random, blocks, random.uniform(0.02, 0.9));
    const BlockStore holed = store_of(random, slots);
    const BlockStore dense = store_of(blocks);
    ASSERT_EQ(holed.stored(), dense.size());
    if (holed.size() == 0) return;
    const Request request = random_request(random, holed, false);
    expect_same_answers(holed, request, dense, present(slots));
    expect_same_active(random, holed, request, dense, present(slots));
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

TEST(EmptySlots, a_store_of_nothing_else_has_nothing_to_select) {
  for (const std::size_t n : {std::size_t{1}, std::size_t{16}, std::size_t{1000}}) {
    TracedRandom random(n);
    BlockStore blocks;
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(push_back_empty(random, blocks), i);
    EXPECT_EQ(blocks.stored(), 0U);
    EXPECT_EQ(blocks.rows(), 0);
    Request request = certified_request(1);
    if (n > 1) request.excluded = random_flags(random, n, 0.5);
    expect_same_answers(blocks, request, BlockStore(), {});
    ActiveSelection active(n);
    ASSERT_EQ(active.start(blocks, request.options(Strategy::greedy)), Error::none);
    EXPECT_EQ(active.next(), ActiveSelection::none);
    EXPECT_EQ(active.selection().status, Status::all_selected);
    request.excluded.clear();
    request.required.resize(n);
    request.required[n / 2] = 1;
    Selector selector = selector_for(blocks, request);
    EXPECT_EQ(selector.select(blocks, request.options(Strategy::greedy)).error, Error::infeasible);
  }
}

}  // namespace
}  // namespace maxlogdet::test
