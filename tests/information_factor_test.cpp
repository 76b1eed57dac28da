// SPDX-License-Identifier: MIT
// The incremental factor, its error bound, and the growths computed from it.
#include "kernel/information_factor.hpp"
#include "simd/kernel.hpp"
#include "tests/oracle.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

using LowerTriangle = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

Matrix6 inverse_of(const InformationFactor& factor) {
  const LowerTriangle w = Eigen::Map<const LowerTriangle>(factor.inverse());
  return w.transpose() * w;
}

// Expects every gain computed from the factor to be as near to the oracle's as the factor's own bound says; returns the
// largest error as a share of that bound.
long double expect_gains_within_bound(const InformationFactor& factor, const BlockStore& blocks,
                                      const GreedyOracle<long double>& oracle) {
  const double bound = factor.gain_error(blocks.max_row_norm());
  std::vector<double> growths(blocks.size());
  (*simd::built_in())
      ->evaluate_range[blocks.rows() - 1]({blocks.plane(0, 0), blocks.stride()}, factor.inverse(), 0, blocks.size(),
                                          growths.data());
  long double largest = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const long double error = std::abs(std::log1p(static_cast<long double>(growths[i])) - oracle.gain(i));
    EXPECT_LE(error, bound) << "candidate " << i;
    largest = std::max(largest, error / bound);
  }
  return largest;
}

void add(InformationFactor& factor, const Block& block) {
  for (int row = 0; row < block.rows(); ++row) factor.add_row(block.row(row).data());
}

TEST(InformationFactor, follows_the_information_through_updates) {
  for (std::uint64_t variation = 0; variation < 200; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Matrix6 information = random_prior(random);
    InformationFactor factor;
    const EigenPrior prior(information);
    ASSERT_TRUE(factor.reset(prior.data()));
    EXPECT_NEAR(factor.prior_log_det(), std::log(information.determinant()), 1e-12);
    for (int update = 0; update < 20; ++update) {
      const Block row = random_block(random, 1, std::pow(10.0, random.integer(-3, 3)));
      factor.add_row(row.data());
      information += row.transpose() * row;
      const Matrix6 identity = inverse_of(factor) * information;
      ASSERT_LT((identity - Matrix6::Identity()).norm(), 1e-6);
    }
    const LowerTriangle w = Eigen::Map<const LowerTriangle>(factor.inverse());
    EXPECT_TRUE(w.isLowerTriangular());
  }
}

// |computed - exact| <= gain_error for every gain that a selection looks at, ill-conditioned rounds included.
TEST(InformationFactor, gain_error_bounds_the_error_of_every_gain) {
  long double tightest = 0;
  for_every_family(60, [&](const BlockStore& blocks) {
    GreedyOracle<long double> oracle(blocks);
    InformationFactor factor;
    ASSERT_TRUE(factor.reset(nullptr));
    for (int round = 0; round < 30; ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      ASSERT_LT(factor.gain_error(blocks.max_row_norm()), 1e-5) << "as docs/numerics.md says";
      tightest = std::max(tightest, expect_gains_within_bound(factor, blocks, oracle));
      const std::size_t chosen = oracle.best();
      oracle.take(chosen);
      add(factor, stored_block(blocks, chosen));
    }
  });
  std::printf("largest error seen: %.2Le of its bound\n", tightest);
  EXPECT_GT(tightest, 0);
}

// Large rows that are nearly parallel, on a prior near the identity: cancellation at its worst.
TEST(InformationFactor, gain_error_bounds_the_error_of_nearly_parallel_rows) {
  for (std::uint64_t variation = 0; variation < 3000; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const double scale = std::pow(10.0, random.uniform(0, 9));
    const double distance = std::pow(10.0, random.uniform(-9, 0));
    const int rows = random.integer(1, 3);
    const Block direction = random_block(random, 1);
    const auto near_parallel = [&] {
      Block block(rows, 6);
      for (int row = 0; row < rows; ++row) block.row(row) = scale * (direction + distance * random_block(random, 1));
      return block;
    };
    BlockStore blocks;
    for (int i = 0; i < 8; ++i) push_back(blocks, near_parallel());
    const Matrix6 information = Matrix6::Identity() + 0.1 * random_prior(random);
    const EigenPrior prior(information);
    InformationFactor factor;
    ASSERT_TRUE(factor.reset(prior.data()));
    GreedyOracle<long double> oracle(blocks, information);
    for (std::size_t round = 0; round < 5; ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      expect_gains_within_bound(factor, blocks, oracle);
      oracle.take(round);
      add(factor, stored_block(blocks, round));
    }
  }
}

TEST(InformationFactor, gives_up_on_laziness_where_float64_has_no_digits) {
  InformationFactor factor;
  ASSERT_TRUE(factor.reset(nullptr));
  EXPECT_LT(factor.gain_error(1e3), 1e-6);
  EXPECT_EQ(factor.gain_error(1e12), std::numeric_limits<double>::infinity()) << "of candidates";
  const double row[6] = {1e13, -2e13, 3e12, 1e13, 5e12, -1e13};
  factor.add_row(row);
  EXPECT_EQ(factor.gain_error(1e13), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace maxlogdet::test
