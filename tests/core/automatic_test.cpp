// SPDX-License-Identifier: MIT
// Which strategy `automatic` chooses, and that its answer is that strategy's.
#include "tests/support/support.hpp"

namespace maxlogdet::test {
namespace {

// The strategy that `automatic` ran; its answer has to be that of requesting it.
Strategy strategy_for(const BlockStore& blocks, Options options) {
  Selector selector(std::max(blocks.size(), options.budget));
  options.strategy = Strategy::automatic;
  const Selection selection = selector.select(blocks, options);
  const Strategy chosen = selection.strategy;
  EXPECT_TRUE(selection.has_answer()) << to_string(selection.status);
  const auto indices = indices_of(selection);
  options.strategy = chosen;
  EXPECT_EQ(indices, select_indices(blocks, options)) << to_string(chosen);
  return chosen;
}

TEST(Automatic, chooses_backward_greedy_from_two_thirds_on) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 300, 1), block_kinds[0]);
  EXPECT_EQ(strategy_for(blocks, with_budget(1)), Strategy::lazy_greedy);
  EXPECT_EQ(strategy_for(blocks, with_budget(199)), Strategy::lazy_greedy);
  EXPECT_EQ(strategy_for(blocks, with_budget(200)), Strategy::backward_greedy);
  EXPECT_EQ(strategy_for(blocks, with_budget(300)), Strategy::backward_greedy);
}

TEST(Automatic, counts_what_constraints_leave) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 300, 1), block_kinds[0]);
  std::vector<unsigned char> excluded(300);
  std::fill_n(excluded.begin(), 150, static_cast<unsigned char>(1));
  Options options = with_budget(100);
  EXPECT_EQ(strategy_for(blocks, options), Strategy::lazy_greedy);
  options.excluded = excluded.data();
  EXPECT_EQ(strategy_for(blocks, options), Strategy::backward_greedy) << "100 of 150";
  const std::vector<std::uint32_t> groups(300);
  options.groups.ids = groups.data();
  options.groups.count = 1;
  options.groups.maximum = 300;
  EXPECT_EQ(strategy_for(blocks, options), Strategy::lazy_greedy) << "that one keeps to groups";
}

TEST(Automatic, relaxes_very_many_candidates) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 50000, 1), block_kinds[3]);
  EXPECT_EQ(strategy_for(blocks, with_budget(59)), Strategy::lazy_greedy);
  EXPECT_EQ(strategy_for(blocks, with_budget(60)), Strategy::relaxed);
  BlockStore fewer(blocks);
  fewer.clear();
  for (std::size_t i = 0; i < 49999; ++i) push_back(fewer, stored_block(blocks, i));
  EXPECT_EQ(strategy_for(fewer, with_budget(60)), Strategy::lazy_greedy);
}

TEST(Automatic, reports_the_requested_strategy_otherwise) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 30, 1), block_kinds[0]);
  Selector selector(30);
  for (const Strategy strategy : sim::strategies) {
    if (strategy == Strategy::automatic) continue;
    Options options = with_budget(5);
    options.strategy = strategy;
    EXPECT_EQ(selector.select(blocks, options).strategy, strategy);
  }
}

}  // namespace
}  // namespace maxlogdet::test
