// SPDX-License-Identifier: MIT
// Which strategy `automatic` chooses, and that its answer is that strategy's.
#include "tests/support/answer.hpp"
#include "tests/support/stores.hpp"

#include <algorithm>

namespace maxlogdet::test {
namespace {

// The strategy that `automatic` ran; its answer has to be that of requesting it.
Strategy strategy_for(const BlockStore& blocks, Options options) {
  options.strategy = Strategy::automatic;
  const Answer answer = answer_to(blocks, options);
  options.strategy = answer.strategy;
  EXPECT_EQ(answer, answer_to(blocks, options));
  return answer.strategy;
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
  const BlockStore fewer = store_of(49999, [&](std::size_t i) { return stored_block(blocks, i); });
  EXPECT_EQ(strategy_for(fewer, with_budget(60)), Strategy::lazy_greedy);
}

TEST(Automatic, is_the_only_one_that_reports_another_strategy) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 30, 1), block_kinds[0]);
  for (const Strategy strategy : strategies) {
    if (strategy == Strategy::automatic) continue;
    EXPECT_EQ(answer_to(blocks, with_budget(5, strategy)).strategy, strategy);
  }
}

}  // namespace
}  // namespace maxlogdet::test
