// SPDX-License-Identifier: MIT
// Backward greedy against an oracle that removes one candidate after the other.
#include "sim/hash.hpp"
#include "tests/core/removals.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

void expect_sorted_and_consistent(const BlockStore& blocks, const Selection& selection) {
  ASSERT_TRUE(selection.has_answer());
  EXPECT_TRUE(std::is_sorted(selection.begin(), selection.end()));
  for (const std::uint32_t i : selection) EXPECT_TRUE(blocks.is_valid(i));
  expect_consistent(blocks, selection, 1e-7);
}

TEST(BackwardGreedy, removes_the_minimum_loss_in_every_round_on_every_family) {
  for_every_family(40, [](const BlockStore& blocks) {
    EXPECT_LE(loss_given_away(blocks, order_of_removal(blocks, keeping(0))), allowed_loss);
  });
}

TEST(BackwardGreedy, removes_the_minimum_loss_in_every_round_among_awkward_candidates) {
  for (std::uint64_t variation = 0; variation < trials(40); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(2, 40)));
    const Matrix6 prior = random_prior(random);
    const EigenPrior eigen_prior(prior);
    Options options = keeping(0);
    options.prior = eigen_prior.data();
    EXPECT_LE(loss_given_away(blocks, order_of_removal(blocks, options), prior), allowed_loss);
  }
}

// Against the default prior a direction that a single candidate observes is worth 20 nats and more.
TEST(BackwardGreedy, keeps_the_only_candidate_that_observes_a_direction) {
  const int directions_by_oracle = static_cast<int>(trials(6));
  for (int direction = 0; direction < 6; ++direction) {
    Random random(static_cast<std::uint64_t>(direction));
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    const auto alone = static_cast<std::uint32_t>(random.integer(0, 79));
    for (std::uint32_t i = 0; i < 80; ++i) {
      Block block = random_block(random, random.integer(1, 3));
      if (i != alone) block.col(direction).setZero();
      push_back(blocks, block);
    }
    for (const std::size_t budget : {70U, 40U, 20U, 6U}) {
      const auto indices = select_indices(blocks, keeping(budget));
      EXPECT_NE(std::find(indices.begin(), indices.end(), alone), indices.end());
    }
    if (direction >= directions_by_oracle) continue;
    EXPECT_LE(loss_given_away(blocks, order_of_removal(blocks, keeping(0), 40)), allowed_loss);
  }
}

TEST(BackwardGreedy, removes_the_highest_index_of_duplicates) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore once = blocks_of(make_scene(sim::Scene::euroc_like, 50, random.seed()), block_kinds[0]);
  BlockStore blocks;
  for (int copy = 0; copy < 3; ++copy) {
    for (std::size_t i = 0; i < once.size(); ++i) push_back(blocks, stored_block(once, i));
  }
  for (const std::size_t budget : {149U, 120U, 75U, 40U, 10U}) {
    const auto indices = select_indices(blocks, keeping(budget));
    const std::set<std::uint32_t> kept(indices.begin(), indices.end());
    for (const std::uint32_t index : indices) {
      if (index >= 50) {
        EXPECT_EQ(kept.count(index - 50), 1U) << index << " was kept and its equal was not";
      }
    }
  }
}

// Losses far below 2^-53 next to each other, and next to far larger ones.
TEST(BackwardGreedy, tells_tiny_losses_apart) {
  BlockStore blocks;
  for (const double size : {1e-12, 1e-11, 1e-3}) {
    for (int i = 0; i < 20; ++i) push_back(blocks, size * Block::Identity(1, 6));
  }
  auto expected = std::vector<std::uint32_t>(30);
  std::iota(expected.begin(), expected.begin() + 10, 20U);
  std::iota(expected.begin() + 10, expected.end(), 40U);
  EXPECT_EQ(select_indices(blocks, keeping(30)), expected);
}

TEST(BackwardGreedy, keeps_what_is_required_and_leaves_out_what_is_excluded_or_invalid) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const auto n = static_cast<std::size_t>(random.integer(30, 100));
    BlockStore blocks;
    std::vector<unsigned char> required(n), excluded(n);
    std::vector<std::uint32_t> expected;
    std::size_t allowed = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const int kind = random.integer(0, 9);
      if (kind == 0) {
        blocks.push_back_invalid();
        continue;
      }
      push_back(blocks, random_block(random, random.integer(1, 3)));
      required[i] = kind == 1 ? 1 : 0;
      excluded[i] = kind == 2 ? 1 : 0;
      allowed += kind != 2 ? 1 : 0;
      if (kind == 1) expected.push_back(static_cast<std::uint32_t>(i));
    }
    for (const std::size_t budget : {expected.size(), allowed - 1, allowed, n}) {
      if (budget < expected.size()) continue;
      Options options = keeping(budget);
      options.required = required.data();
      options.excluded = excluded.data();
      Selector selector(n);
      const Selection selection = selector.select(blocks, options);
      EXPECT_EQ(selection.status, budget < allowed ? Status::ok : Status::all_selected);
      ASSERT_EQ(selection.size, std::min(budget, allowed));
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), selection.begin()));
      EXPECT_TRUE(std::is_sorted(selection.begin() + expected.size(), selection.end()));
      for (const std::uint32_t i : selection) EXPECT_TRUE(blocks.is_valid(i) && excluded[i] == 0);
      EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-7);
      expect_the_same_with_stale_bounds(blocks, options);
    }
  }
}

TEST(BackwardGreedy, does_not_support_groups) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  const std::vector<std::uint32_t> groups(20, 0U);
  Options options = keeping(5);
  options.groups.ids = groups.data();
  options.groups.count = 1;
  Selector selector(20);
  EXPECT_EQ(selector.select(blocks, options).error, Error::unsupported_groups);
}

TEST(BackwardGreedy, never_beats_the_optimum) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, 8);
    const auto budget = static_cast<std::size_t>(random.integer(1, 7));
    long double optimum = -1e30L;
    for (unsigned subset = 0; subset < 256; ++subset) {
      std::vector<std::uint32_t> indices;
      for (std::uint32_t i = 0; i < 8; ++i) {
        if ((subset >> i & 1U) != 0) indices.push_back(i);
      }
      if (indices.size() == budget) optimum = std::max(optimum, log_det_of(blocks, indices));
    }
    EXPECT_LE(log_det_of(blocks, select_indices(blocks, keeping(budget))), optimum + 1e-10L);
  }
}

TEST(BackwardGreedy, lists_by_index_gains_that_add_up) {
  for_every_family(300, [](const BlockStore& blocks) {
    Selector selector(300);
    expect_sorted_and_consistent(blocks, selector.select(blocks, keeping(200)));
  });
}

TEST(BackwardGreedy, is_as_good_as_greedy_where_most_are_kept) {
  for_every_family(500, [](const BlockStore& blocks) {
    Selector selector(500);
    Options options = keeping(400);
    const double backward = selector.select(blocks, options).log_det;
    options.strategy = Strategy::lazy_greedy;
    EXPECT_NEAR(backward, selector.select(blocks, options).log_det, 1e-2);
  });
}

TEST(BackwardGreedy, stops_at_the_deadline_with_a_valid_answer) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 5000, random.seed()), block_kinds[0]);
  Selector selector(5000);
  Options options = keeping(2500);
  const Selection full = selector.select(blocks, options);
  EXPECT_EQ(full.status, Status::ok);
  const double log_det = full.log_det;
  for (const double limit : {1e-9, 3e-4, 6e-4, 1e-3}) {
    options.time_limit = limit;
    const Selection selection = selector.select(blocks, options);
    ASSERT_TRUE(selection.has_answer());
    EXPECT_EQ(selection.size, 2500U);
    EXPECT_GE(selection.log_det, log_det - 0.1) << limit;
    if (limit < 1e-8) {
      EXPECT_EQ(selection.status, Status::deadline_reached);
    }
    EXPECT_EQ(selection.searched, selection.status == Status::ok ? 2500U : 0U);
    EXPECT_EQ(std::set<std::uint32_t>(selection.begin(), selection.end()).size(), 2500U);
    expect_consistent(blocks, selection, 1e-8);
  }
}

TEST(BackwardGreedy, removes_the_minimum_loss_on_real_frames) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(17, [](const BlockStore& all) {
    expect_the_same_with_stale_bounds(all, keeping(all.size() / 2));
    BlockStore some;
    for (std::size_t j = 0; j < std::min<std::size_t>(all.size(), 50); ++j) push_back(some, stored_block(all, j));
    EXPECT_LE(loss_given_away(some, order_of_removal(some, keeping(0), 25)), allowed_loss);
  });
}

// One number for all families, recorded once: no compiler, instruction set or C library may change it.
TEST(BackwardGreedy, gives_the_recorded_answers) {
  sim::Hash hash;  // over the indices
  for_every_recorded(500, [&](const BlockStore& blocks) {
    for (const std::uint32_t index : select_indices(blocks, keeping(250))) hash.add(index);
  });
  EXPECT_EQ(hash.value(), 9854850364897203626U);
}

}  // namespace
}  // namespace maxlogdet::test
