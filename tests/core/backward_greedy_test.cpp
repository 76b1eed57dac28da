// SPDX-License-Identifier: MIT
// Backward greedy against an oracle that removes one candidate after the other.
#include "tests/core/removals.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

TEST(BackwardGreedy, removes_the_minimum_loss_in_every_round_on_every_family) {
  for_every_family(
      40, [](const BlockStore& blocks) { EXPECT_LE(loss_given_away(problem_of(blocks, 0), 0), allowed_loss); });
}

TEST(BackwardGreedy, removes_the_minimum_loss_in_every_round_among_awkward_candidates) {
  for_each_trial(40, [](Random& random) {
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(2, 40)));
    Problem problem = problem_of(blocks, 0);
    problem.set_prior(random_prior(random));
    if (random.chance(0.5)) problem.required = random_flags(random, blocks.size(), 0.3);
    EXPECT_LE(loss_given_away(problem, problem.required_count()), allowed_loss);
  });
}

TEST(RealFrames, backward_greedy_removes_the_minimum_loss) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(17, [](const BlockStore& all) {
    expect_the_same_with_stale_bounds(all, keeping(all.size() / 2));
    const BlockStore some =
        store_of(std::min<std::size_t>(all.size(), 50), [&](std::size_t i) { return stored_block(all, i); });
    EXPECT_LE(loss_given_away(problem_of(some, 0), 25), allowed_loss);
  });
}

// Against the default prior a direction that a single candidate observes is worth 20 nats and more.
TEST(BackwardGreedy, keeps_the_only_candidate_that_observes_a_direction) {
  const int directions_by_oracle = static_cast<int>(trials(6));
  for (int direction = 0; direction < 6; ++direction) {
    Random random(static_cast<std::uint64_t>(direction));
    SCOPED_TRACE(random.name());
    const std::size_t alone = random.index(80);
    const BlockStore blocks = store_of(80, [&](std::size_t i) {
      Block block = random_block(random, random.integer(1, 3));
      if (i != alone) block.col(direction).setZero();
      return block;
    });
    for (const std::size_t budget : {70U, 40U, 20U, 6U}) {
      const auto indices = select_indices(blocks, keeping(budget));
      EXPECT_NE(std::find(indices.begin(), indices.end(), alone), indices.end());
    }
    if (direction >= directions_by_oracle) continue;
    EXPECT_LE(loss_given_away(problem_of(blocks, 0), 40), allowed_loss);
  }
}

// Equal blocks, and blocks of the opposite sign, whose information is the same.
TEST(BackwardGreedy, removes_the_highest_index_of_duplicates) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore once = blocks_of(make_scene(sim::Scene::euroc_like, 50, random.seed()), block_kinds[0]);
  for (const double sign : {1.0, -1.0}) {
    const BlockStore blocks =
        store_of(150, [&](std::size_t i) { return Block(stored_block(once, i % 50) * (i / 50 == 1 ? sign : 1)); });
    for (const std::size_t budget : {149U, 120U, 75U, 40U, 10U}) {
      const auto indices = select_indices(blocks, keeping(budget));
      const std::set<std::uint32_t> kept(indices.begin(), indices.end());
      for (const std::uint32_t index : indices) {
        EXPECT_TRUE(index < 50 || kept.count(index - 50) == 1) << index << " was kept and its equal was not";
      }
    }
  }
}

// Losses far below 2^-53 next to each other, and next to far larger ones.
TEST(BackwardGreedy, tells_tiny_losses_apart) {
  const double sizes[] = {1e-12, 1e-11, 1e-3};
  const BlockStore blocks = store_of(60, [&](std::size_t i) { return Block(sizes[i / 20] * Block::Identity(1, 6)); });
  std::vector<std::uint32_t> expected(30);
  std::iota(expected.begin(), expected.begin() + 10, 20U);
  std::iota(expected.begin() + 10, expected.end(), 40U);
  EXPECT_EQ(select_indices(blocks, keeping(30)), expected);
}

TEST(BackwardGreedy, lists_what_is_required_and_then_by_index_gains_that_add_up) {
  for_each_trial(100, [](Random& random) {
    Problem problem = problem_of(scaled(random, random_store(random, 30 + random.index(70)), 1, 0.1), 0);
    constrain(random, problem, false);
    const std::size_t required = problem.required_count();
    Selector selector(problem.blocks.size() + 3);
    for (const std::size_t budget : {required, problem.plain.budget, problem.blocks.size()}) {
      problem.plain.budget = budget;
      const Options options = problem.options(Strategy::backward_greedy);
      const Selection selection = selector.select(problem.blocks, options);
      expect_sound(problem, selection);
      EXPECT_TRUE(std::is_sorted(selection.begin(), selection.begin() + required));
      EXPECT_TRUE(std::is_sorted(selection.begin() + required, selection.end()));
      for (std::size_t j = 0; j < required; ++j) EXPECT_TRUE(problem.is_required(selection.indices[j]));
      expect_the_same_with_stale_bounds(problem.blocks, options);
    }
  });
}

TEST(BackwardGreedy, is_as_good_as_greedy_where_most_are_kept) {
  for_every_family(500, [](const BlockStore& blocks) {
    Selector selector(500);
    const Selection backward = selector.select(blocks, keeping(400));
    EXPECT_TRUE(std::is_sorted(backward.begin(), backward.end()));
    expect_consistent(blocks, backward, 1e-7);
    const double log_det = backward.log_det;
    EXPECT_NEAR(log_det, selector.select(blocks, with_budget(400, Strategy::lazy_greedy)).log_det, 1e-2);
  });
}

TEST(BackwardGreedy, looks_at_the_clock_among_the_last_few) {
  TracedRandom random;
  Options options = with_budget(5, Strategy::backward_greedy);
  options.time_limit = 1e-9;
  EXPECT_EQ(answer_to(random_store(random, 10, 1, 2), options).reason, "deadline_reached");
}

TEST(BackwardGreedy, loses_little_at_a_deadline) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 5000, random.seed()), block_kinds[0]);
  Selector selector(5000);
  Options options = keeping(2500);
  const double log_det = selector.select(blocks, options).log_det;
  for (const double limit : {1e-9, 3e-4, 6e-4, 1e-3}) {
    options.time_limit = limit;
    EXPECT_GE(selector.select(blocks, options).log_det, log_det - 0.1) << limit;
  }
}

}  // namespace
}  // namespace maxlogdet::test
