// SPDX-License-Identifier: MIT
// Greedy against the oracle, and lazy greedy against greedy.
#include "sim/hash.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"

#include <numeric>

namespace maxlogdet::test {
namespace {

// Everything that has to hold of a selection of `budget` candidates by greedy.
void expect_greedy(const BlockStore& blocks, std::size_t budget) {
  Selector selector(std::max(blocks.size(), budget));
  const Selection greedy = selector.select(blocks, with_budget(budget, Strategy::greedy));
  const auto indices = indices_of(greedy);
  EXPECT_EQ(indices, GreedyOracle<double>(blocks).select(budget));
  EXPECT_NEAR(greedy.log_det, static_cast<double>(log_det_of(blocks, indices)), 1e-8);
  EXPECT_EQ(indices_of(selector.select(blocks, with_budget(budget, Strategy::lazy_greedy))), indices);
}

TEST(Greedy, equals_the_oracle_on_generated_frames) {
  for_every_family(300, [&](const BlockStore& blocks) { expect_greedy(blocks, 60); });
}

TEST(Greedy, equals_the_oracle_on_a_frame_of_2000) {
  const Random random;
  SCOPED_TRACE(random.name());
  expect_greedy(blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[0]), 100);
}

TEST(Greedy, gives_away_nothing_in_any_round) {
  for_every_family(200, [&](const BlockStore& blocks) {
    const auto indices = select_indices(blocks, with_budget(40, Strategy::greedy));
    EXPECT_LE(gain_given_away(blocks, indices), allowed_loss);
  });
}

TEST(Greedy, takes_the_lowest_index_of_duplicated_candidates) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore once = blocks_of(make_scene(sim::Scene::euroc_like, 100, random.seed()), block_kinds[0]);
  BlockStore blocks;  // every candidate three times, far apart
  for (int copy = 0; copy < 3; ++copy) {
    for (std::size_t i = 0; i < once.size(); ++i) push_back(blocks, stored_block(once, i));
  }
  expect_greedy(blocks, 60);
  const auto indices = select_indices(blocks, with_budget(60, Strategy::lazy_greedy));
  std::vector<bool> is_taken(blocks.size());
  for (const std::uint32_t index : indices) {
    for (std::size_t earlier = index % once.size(); earlier < index; earlier += once.size()) {
      EXPECT_TRUE(is_taken[earlier]) << index << " was taken before its equal " << earlier;
    }
    is_taken[index] = true;
  }
}

TEST(Greedy, tells_candidates_apart_that_differ_in_the_last_bit_of_one_entry) {
  for (std::uint64_t variation = 0; variation < trials(20); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore some = blocks_of(make_scene(sim::Scene::euroc_like, 20, random.seed()), block_kinds[3]);
    BlockStore blocks;
    for (int copy = 0; copy < 10; ++copy) {
      for (std::size_t i = 0; i < some.size(); ++i) {
        Block block = stored_block(some, i);
        double& entry = block(random.integer(0, 1), random.integer(2, 5));
        const float towards = random.chance(0.5) ? 1e30F : -1e30F;
        entry = static_cast<double>(std::nextafter(static_cast<float>(entry), towards));
        push_back(blocks, block);
      }
    }
    Selector selector(blocks.size());
    const auto greedy = indices_of(selector.select(blocks, with_budget(30, Strategy::greedy)));
    EXPECT_LE(gain_given_away(blocks, greedy), allowed_loss);
    EXPECT_EQ(greedy, GreedyOracle<double>(blocks).select(30));
    EXPECT_EQ(indices_of(selector.select(blocks, with_budget(30, Strategy::lazy_greedy))), greedy);
  }
}

TEST(Greedy, gains_shrink_and_add_up_to_log_det) {
  for (std::uint64_t variation = 0; variation < trials(50); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, 60);
    const Matrix6 prior = random_prior(random);
    const EigenPrior eigen_prior(prior);
    Options options = with_budget(30, Strategy::greedy);
    options.prior = eigen_prior.data();
    Selector selector(100);
    const Selection selection = selector.select(blocks, options);
    ASSERT_EQ(selection.size, 30U);
    for (std::size_t i = 1; i < selection.size; ++i) EXPECT_LE(selection.gains[i], selection.gains[i - 1] + 1e-9);
    const double sum = std::accumulate(selection.gains, selection.gains + selection.size, 0.0);
    EXPECT_NEAR(selection.log_det, log_det(prior) + sum, 1e-9);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection), prior)), 1e-9);
  }
}

TEST(Greedy, evaluates_every_remaining_candidate_in_every_round) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 50);
  Selector selector(50);
  EXPECT_EQ(selector.select(blocks, with_budget(4, Strategy::greedy)).evaluations, 50U + 49U + 48U + 47U);
}

TEST(LazyGreedy, equals_greedy_on_awkward_candidates) {
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    const auto budget = static_cast<std::size_t>(random.integer(1, 60));
    EXPECT_EQ(select_indices(blocks, with_budget(budget, Strategy::lazy_greedy)),
              select_indices(blocks, with_budget(budget, Strategy::greedy)));
  }
}

// Copies of a few blocks, some moved by one float32 ulp, at scales where rounding is as large as what tells them apart:
// here a stale maximum without its error bound is now and then below a gain computed later.
TEST(LazyGreedy, equals_greedy_where_rounding_reorders_near_copies) {
  for (std::uint64_t variation = 0; variation < trials(5000); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = near_copies(random, -1, 8);
    const auto n = static_cast<int>(blocks.size());
    const auto budget = static_cast<std::size_t>(random.integer(1, n / 2));
    ASSERT_EQ(select_indices(blocks, with_budget(budget, Strategy::lazy_greedy)),
              select_indices(blocks, with_budget(budget, Strategy::greedy)));
  }
}

// Where float64 itself has no digits left (blocks of 1e12 against a prior of 1e-5) rounding decides greedy's choices,
// and lazy greedy must still make the same ones.
TEST(LazyGreedy, equals_greedy_at_every_scale) {
  for (int exponent = -30; exponent <= 30; exponent += 2) {
    Random random(static_cast<std::uint64_t>(exponent + 30));
    SCOPED_TRACE(random.name() + ", scale 1e" + std::to_string(exponent));
    BlockStore blocks;
    for (int i = 0; i < 100; ++i) push_back(blocks, random_block(random, 2, std::pow(10.0, exponent)));
    for (int i = 0; i < 100; ++i) push_back(blocks, stored_block(blocks, static_cast<std::size_t>(i)) / 2);
    EXPECT_EQ(select_indices(blocks, with_budget(50, Strategy::lazy_greedy)),
              select_indices(blocks, with_budget(50, Strategy::greedy)));
  }
}

TEST(LazyGreedy, equals_greedy_on_2000_candidates_and_evaluates_less) {
  for_every_family(2000, [&](const BlockStore& blocks) {
    Selector greedy(2000);
    Selector lazy(2000);
    const Selection of_greedy = greedy.select(blocks, with_budget(100, Strategy::greedy));
    const Selection of_lazy = lazy.select(blocks, with_budget(100, Strategy::lazy_greedy));
    EXPECT_EQ(indices_of(of_lazy), indices_of(of_greedy));
    EXPECT_EQ(of_lazy.log_det, of_greedy.log_det);
    EXPECT_LT(of_lazy.evaluations, of_greedy.evaluations);
  });
}

// One number for all selections on all families, recorded once: no compiler, instruction set or C library may change
// it.
TEST(Greedy, gives_the_recorded_answers) {
  sim::Hash hash;  // over the indices
  for_every_recorded(500, [&](const BlockStore& blocks) {
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
      for (const std::uint32_t index : select_indices(blocks, with_budget(100, strategy))) hash.add(index);
    }
  });
  EXPECT_EQ(hash.value(), 6618130281619646114U);
}

TEST(RealFrames, greedy_equals_the_oracle_on_every_frame) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(1, [](const BlockStore& blocks) { expect_greedy(blocks, 100); });
}

TEST(RealFrames, greedy_gives_away_nothing_in_any_round) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(7, [](const BlockStore& blocks) {
    EXPECT_LE(gain_given_away(blocks, select_indices(blocks, with_budget(60, Strategy::greedy))), allowed_loss);
  });
}

}  // namespace
}  // namespace maxlogdet::test
