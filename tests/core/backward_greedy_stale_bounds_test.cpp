// SPDX-License-Identifier: MIT
// Backward greedy with stale bounds of losses gives the answer that it gives without them, on every instruction set.
#include "kernel/blocks/candidates.hpp"
#include "kernel/information/information_factor.hpp"
#include "tests/core/removals.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/linear_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

namespace maxlogdet::test {
namespace {

TEST(BackwardGreedy, is_the_same_with_stale_bounds_on_every_family) {
  for_every_family(600, [](const BlockStore& blocks) {
    expect_the_same_with_stale_bounds(blocks, keeping(300));
    expect_the_same_with_stale_bounds(blocks, keeping(5));
  });
}

TEST(BackwardGreedy, is_the_same_with_stale_bounds_among_awkward_candidates) {
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    const EigenPrior prior(random_prior(random));
    Options options = keeping(static_cast<std::size_t>(random.integer(0, static_cast<int>(blocks.size()))));
    if (random.chance(0.5)) options.prior = prior.data();
    expect_the_same_with_stale_bounds(blocks, options);
  }
}

// Copies of a few blocks, some moved by one float32 ulp: float64 has to tell dozens apart in every round.
TEST(BackwardGreedy, is_the_same_with_stale_bounds_among_near_copies) {
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = near_copies(random, -3, 8);
    const auto n = static_cast<int>(blocks.size());
    expect_the_same_with_stale_bounds(blocks, keeping(static_cast<std::size_t>(random.integer(1, n))));
  }
}

// Copies of rows along six directions. Removing one changes the losses along the other five by rounding
// only, and the prior puts them midway between two float32 numbers: bounds have to allow for it.
TEST(BackwardGreedy, is_the_same_with_stale_bounds_where_losses_change_by_rounding_only) {
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
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
    Options options = keeping(blocks.size() - static_cast<std::size_t>(random.integer(1, 5)));
    options.prior = eigen_prior.data();
    expect_the_same_with_stale_bounds(blocks, options);
  }
}

TEST(BackwardGreedy, is_the_same_with_stale_bounds_and_well_formed_at_every_scale) {
  for (int exponent = -30; exponent <= 30; exponent += 2) {
    Random random(static_cast<std::uint64_t>(exponent + 30));
    SCOPED_TRACE(random.name() + ", scale 1e" + std::to_string(exponent));
    BlockStore blocks;
    for (int i = 0; i < 50; ++i) push_back(blocks, random_block(random, 2, std::pow(10.0, exponent)));
    for (int i = 0; i < 50; ++i) push_back(blocks, stored_block(blocks, static_cast<std::size_t>(i)) / 2);
    expect_the_same_with_stale_bounds(blocks, keeping(50));
    Selector selector(100);
    const Selection selection = selector.select(blocks, keeping(50));
    EXPECT_EQ(selection.status, Status::ok);
    EXPECT_EQ(selection.size, 50U);
    EXPECT_TRUE(std::isfinite(selection.log_det));
    if (exponent > 8) continue;  // beyond, float64 has no digits left in the first gains
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-6);
  }
}

// An unobserved direction, and rows so long that float64 has no digits of it.
TEST(BackwardGreedy, is_the_same_with_stale_bounds_and_well_formed_with_a_direction_unobserved) {
  for (int exponent = -3; exponent <= 12; exponent += 3) {
    Random random(static_cast<std::uint64_t>(exponent + 3));
    SCOPED_TRACE(random.name() + ", scale 1e" + std::to_string(exponent));
    BlockStore blocks;
    for (int i = 0; i < 300; ++i) {
      Block block = random_block(random, 2, std::pow(10.0, exponent));
      block.col(exponent % 2 == 0 ? 3 : 0).setZero();
      push_back(blocks, block);
    }
    expect_the_same_with_stale_bounds(blocks, keeping(150));
    Selector selector(300);
    const Selection selection = selector.select(blocks, keeping(150));
    EXPECT_EQ(selection.size, 150U);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-5);
    if (exponent > 3) continue;
    Options greedy = keeping(150);
    greedy.strategy = Strategy::greedy;
    EXPECT_NEAR(selection.log_det, selector.select(blocks, greedy).log_det, 0.05);
  }
}

TEST(BackwardGreedy, is_the_same_on_every_instruction_set) {
  for_every_family(700, [](const BlockStore& blocks) {
    std::vector<std::uint32_t> expected;
    std::vector<double> gains;
    for (const std::string& isa : sim::supported_isas()) {
      const ForcedIsa forced(isa.c_str());
      Selector selector(700);
      const Selection selection = selector.select(blocks, keeping(400));
      if (expected.empty()) {
        expected = indices_of(selection);
        gains.assign(selection.gains, selection.gains + selection.size);
      }
      EXPECT_EQ(indices_of(selection), expected) << isa;
      EXPECT_EQ(std::memcmp(selection.gains, gains.data(), gains.size() * sizeof(double)), 0) << isa;
    }
  });
}

// Losses in float64 have the same bits in every lane and on every instruction set.
TEST(BackwardGreedy, losses_are_the_same_bits_on_all_and_near_the_exact_ones) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    constexpr std::size_t lanes = 2 * simd::tile_size;
    const BlockStore blocks = awkward_blocks(random, lanes);
    InformationFactor factor;
    ASSERT_TRUE(factor.reset(nullptr));
    GreedyOracle<long double> oracle(blocks);
    for (std::uint32_t i = 0; i < lanes; ++i) {
      double rows[max_block_rows][6] = {};
      const Block block = stored_block(blocks, i);
      for (int row = 0; row < block.rows(); ++row) {
        for (int column = 0; column < 6; ++column) rows[row][column] = block(row, column);
      }
      factor.add_block(*simd::built_in()[0], rows, blocks.rows());
    }
    std::vector<float> remaining(lanes, 1.0F);
    remaining[7] = 0;
    const simd::Planes planes = all_of(blocks).planes;
    const simd::Tiles tiles{planes.data, simd::tile_size, planes.stride, remaining.data()};
    const std::uint32_t list[] = {1, 0};
    std::vector<double> expected;
    for (const simd::Kernel* const kernel : supported_kernels()) {
      std::vector<double> results(lanes + 2);
      kernel->losses[blocks.rows() - 1](tiles, factor.inverse(), list, 2, results.data(), results.data() + lanes);
      if (expected.empty()) expected = results;
      EXPECT_EQ(std::memcmp(results.data(), expected.data(), results.size() * sizeof(double)), 0) << kernel->isa;
    }
    EXPECT_EQ(expected[7], simd::no_loss);
    EXPECT_EQ(expected[lanes], *std::min_element(expected.begin(), expected.begin() + simd::tile_size));
    for (std::uint32_t i = 0; i < lanes; ++i) {
      if (i == 7) continue;
      GreedyOracle<long double> others(blocks);
      for (std::uint32_t j = 0; j < lanes; ++j) {
        if (j != i) others.take(j);
      }
      EXPECT_NEAR(expected[i], static_cast<double>(-std::expm1(-others.gain(i))), 1e-9);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
