// SPDX-License-Identifier: MIT
// The memory of a store, and Eigen's matrices in it. empty_slots_test.cpp shows that a store holds what it was given.
#include "kernel/blocks/block_planes.hpp"
#include "tests/support/stores.hpp"

#include <Eigen/Cholesky>
#include <cstdint>
#include <limits>
#include <new>
#include <utility>

namespace maxlogdet::test {
namespace {

TEST(BlockStore, planes_are_aligned_to_64_bytes) {
  for (const std::size_t capacity : {1U, 15U, 16U, 17U, 1000U, 2048U}) {
    const BlockStore blocks(capacity);
    EXPECT_EQ(blocks.capacity(), capacity);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 6; ++column) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(planes_of(blocks).plane(row, column)) % 64, 0U);
      }
    }
  }
}

// Of a store that holds a block, and of one that was moved from.
TEST(BlockStore, more_candidates_than_indices_are_refused) {
  constexpr std::size_t max_index = std::numeric_limits<std::uint32_t>::max();
  BlockStore blocks = copies_of(Block::Ones(2, 6), 1), empty;
  const BlockStore moved = std::move(empty);
  for (const std::size_t capacity : {max_index + 1, 2 * max_index, std::numeric_limits<std::size_t>::max()}) {
    EXPECT_THROW(blocks.reserve(capacity), std::bad_alloc) << capacity;
    EXPECT_THROW(empty.reserve(capacity), std::bad_alloc);  // NOLINT(bugprone-use-after-move)
    EXPECT_THROW(BlockStore{capacity}, std::bad_alloc) << capacity;
  }
  EXPECT_EQ(stored_block(blocks, 0), Block::Ones(2, 6));
  EXPECT_EQ(blocks.capacity(), 64U);
  EXPECT_EQ(empty.capacity(), 0U);
}

TEST(EigenAdapter, takes_blocks_of_any_scalar_and_storage_order) {
  Random random;
  const Block block = rounded(random_block(random, 2));
  BlockStore blocks;
  push_back(blocks, block);
  push_back(blocks, block.cast<float>());
  const Eigen::Matrix<double, 2, 6> fixed = block;
  push_back(blocks, fixed);
  const Eigen::MatrixXd dynamic = block;
  push_back(blocks, dynamic);
  push_back(blocks, 2 * dynamic - dynamic);  // an expression
  for (std::size_t i = 0; i < blocks.size(); ++i) EXPECT_EQ(stored_block(blocks, i), block) << i;
  push_back(blocks, Eigen::MatrixXd::Zero(4, 6).eval());
  push_back(blocks, Eigen::MatrixXd::Zero(2, 5).eval());
  push_back(blocks, Eigen::MatrixXd::Zero(0, 6).eval());
  EXPECT_EQ(blocks.invalid_count(), 3U);
}

TEST(EigenAdapter, passes_a_prior) {
  Random random;
  const Matrix6 information = random_prior(random);
  const EigenPrior prior(information);
  Options options;
  options.budget = 0;
  options.prior = prior.data();
  Selector selector(1);
  const double log_det = selector.select(BlockStore(), options).log_det;
  EXPECT_NEAR(log_det, 2 * information.llt().matrixLLT().diagonal().array().log().sum(), 1e-12);
}

}  // namespace
}  // namespace maxlogdet::test
