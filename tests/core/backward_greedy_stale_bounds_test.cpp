// SPDX-License-Identifier: MIT
// Backward greedy with stale bounds of losses gives the answer that it gives without them, on every instruction set.
#include "kernel/blocks/candidates.hpp"
#include "tests/core/factors.hpp"
#include "tests/core/removals.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

TEST(BackwardGreedy, is_the_same_with_stale_bounds_on_every_family) {
  for_every_family(600, [](const BlockStore& blocks) {
    expect_the_same_with_stale_bounds(blocks, keeping(300));
    expect_the_same_with_stale_bounds(blocks, keeping(5));
  });
}

TEST(BackwardGreedy, is_the_same_with_stale_bounds_among_awkward_candidates) {
  for_each_trial(300, [](Random& random) {
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    const EigenPrior prior(random_prior(random));
    Options options = keeping(random.index(blocks.size() + 1));
    if (random.chance(0.5)) options.prior = prior.data();
    expect_the_same_with_stale_bounds(blocks, options);
  });
}

// Copies of a few blocks, some moved by one float32 ulp: float64 has to tell dozens apart in every round.
TEST(BackwardGreedy, is_the_same_with_stale_bounds_among_near_copies) {
  for_each_trial(500, [](Random& random) {
    const BlockStore blocks = near_copies(random, -3, 8);
    expect_the_same_with_stale_bounds(blocks, keeping(1 + random.index(blocks.size())));
  });
}

// Copies of rows along six directions. Removing one changes the losses along the other five by rounding
// only, and the prior puts them midway between two float32 numbers: bounds have to allow for it.
TEST(BackwardGreedy, is_the_same_with_stale_bounds_where_losses_change_by_rounding_only) {
  for_each_trial(500, [](Random& random) {
    const Matrix6 directions = orthogonal_factor(random_prior(random));
    const double loss = 0x1p-6 + 0x1p-30;
    Matrix6 prior = Matrix6::Zero();
    BlockStore blocks;
    for (int i = 0; i < 6; ++i) {
      const Block row = rounded(directions.row(i) * random.uniform(1, 2));
      const int copies = random.integer(20, 60);
      for (int copy = 0; copy < copies; ++copy) push_back(blocks, row);
      prior += (1 / loss - copies) * row.transpose() * row;
    }
    const EigenPrior eigen_prior(prior);
    Options options = keeping(blocks.size() - 1 - random.index(5));
    options.prior = eigen_prior.data();
    expect_the_same_with_stale_bounds(blocks, options);
  });
}

TEST(BackwardGreedy, is_the_same_with_stale_bounds_and_well_formed_at_every_scale) {
  for_each_exponent(-30, 30, [](Random& random, int exponent) {
    const BlockStore large = random_store(random, 50, std::pow(10.0, exponent), 2);
    const BlockStore blocks =
        store_of(100, [&](std::size_t i) { return Block(stored_block(large, i % 50) / (i < 50 ? 1 : 2)); });
    expect_the_same_with_stale_bounds(blocks, keeping(50));
    Selector selector(100);
    const Selection selection = selector.select(blocks, keeping(50));
    EXPECT_EQ(selection.status, Status::ok);
    EXPECT_EQ(selection.size, 50U);
    EXPECT_TRUE(std::isfinite(selection.log_det));
    if (exponent > 8) return;  // beyond, float64 has no digits left in the first gains
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-6);
  });
}

// An unobserved direction, and rows so long that float64 has no digits of it.
TEST(BackwardGreedy, is_the_same_with_stale_bounds_and_well_formed_with_a_direction_unobserved) {
  for_each_exponent(-3, 12, [](Random& random, int exponent) {
    const BlockStore blocks = store_of(300, [&](std::size_t) {
      Block block = random_block(random, 2, std::pow(10.0, exponent));
      block.col(exponent % 2 == 0 ? 3 : 0).setZero();
      return block;
    });
    expect_the_same_with_stale_bounds(blocks, keeping(150));
    Selector selector(300);
    const Selection selection = selector.select(blocks, keeping(150));
    const double log_det = selection.log_det;
    EXPECT_EQ(selection.size, 150U);
    EXPECT_NEAR(log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-5);
    if (exponent > 3) return;
    EXPECT_NEAR(log_det, selector.select(blocks, with_budget(150, Strategy::greedy)).log_det, 0.05);
  });
}

// Losses in float64 have the same bits in every lane and on every instruction set.
TEST(BackwardGreedy, losses_are_the_same_bits_on_all_and_near_the_exact_ones) {
  for_each_trial(100, [](Random& random) {
    constexpr std::size_t lanes = 2 * simd::tile_size;
    const BlockStore blocks = awkward_blocks(random, lanes);
    InformationFactor factor;
    ASSERT_TRUE(factor.reset(nullptr));
    for (std::size_t i = 0; i < lanes; ++i) add(factor, stored_block(blocks, i));
    std::vector<float> remaining(lanes, 1.0F);
    remaining[7] = 0;
    const simd::Planes planes = all_of(blocks).planes;
    const simd::Tiles tiles{planes.data, simd::tile_size, planes.stride, 2, remaining.data(), nullptr};
    const Tile list[] = {Tile{1}, Tile{0}};
    const std::vector<double> losses = same_on_every_kernel([&](const simd::Kernel& kernel) {
      std::vector<double> results(lanes + 2);
      kernel.exact[blocks.rows() - 1].losses(tiles, factor.inverse(), list, 2, results.data(), results.data() + lanes);
      return results;
    });
    EXPECT_EQ(losses[7], simd::no_loss);
    EXPECT_EQ(losses[lanes], *std::min_element(losses.begin(), losses.begin() + simd::tile_size));
    for (std::uint32_t i = 0; i < lanes; ++i) {
      if (i == 7) continue;
      GreedyOracle<long double> others(blocks);
      for (std::uint32_t j = 0; j < lanes; ++j) {
        if (j != i) others.take(j);
      }
      EXPECT_NEAR(losses[i], static_cast<double>(-std::expm1(-others.gain(i))), 1e-9);
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
