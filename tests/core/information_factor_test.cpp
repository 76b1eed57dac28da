// SPDX-License-Identifier: MIT
// The incremental factor and the bound of its error.
#include "kernel/blocks/block_planes.hpp"
#include "tests/core/factors.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

Matrix6 w_of(const InformationFactor& factor) {
  Matrix6 w;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) w(i, j) = factor.inverse()[simd::padded_dimension * i + j];
  }
  return w;
}

// Expects (1 - f) M^-1 <= W^T W <= (1 + f) M^-1, with the triangle R of a QR decomposition of everything stacked, M =
// R^T R: the singular values of W R^T squared lie between. Returns the largest deviation as a share of f.
long double expect_within_relative_error(const InformationFactor& factor, const GreedyOracle<long double>& oracle) {
  const WideMatrix ratio = wide_product(w_of(factor).cast<long double>(), oracle.factor().transpose());
  const WideVector6 squares = wide_eigenvalues(wide_gram(ratio.transpose()));
  const long double deviation = std::max(std::abs(squares(0) - 1), std::abs(squares(5) - 1));
  const long double f = factor.relative_error();
  EXPECT_LE(deviation, f);
  return deviation / f;
}

TEST(InformationFactor, stays_within_its_relative_error_on_every_family) {
  long double tightest = 0;
  for_every_family(60, [&](const BlockStore& blocks) {
    GreedyOracle<long double> oracle(blocks);
    InformationFactor factor = factor_of(default_information(blocks));
    for (int round = 0; round < 30; ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      tightest = std::max(tightest, expect_within_relative_error(factor, oracle));
      EXPECT_TRUE(w_of(factor).isLowerTriangular());
      const std::size_t chosen = oracle.best();
      oracle.take(chosen);
      add(factor, stored_block(blocks, chosen));
    }
  });
  std::printf("largest deviation seen: %.2Le of its bound\n", tightest);
  EXPECT_GT(tightest, 0);
}

// Eight blocks of long rows that are nearly parallel.
BlockStore nearly_parallel_blocks(Random& random) {
  const double scale = std::pow(10.0, random.uniform(0, 6));
  const double distance = std::pow(10.0, random.uniform(-6, 0));
  const Block direction = random_block(random, 1);
  BlockStore blocks;
  for (int i = 0; i < 8; ++i) {
    Block block(random.integer(1, 3), 6);
    for (int row = 0; row < block.rows(); ++row) {
      block.row(row) = scale * (direction + distance * random_block(random, 1));
    }
    push_back(blocks, block);
  }
  return blocks;
}

// On a prior near the identity: rows as long as 1e6 that are nearly parallel.
TEST(InformationFactor, stays_within_its_relative_error_on_nearly_parallel_rows) {
  for_each_trial(1000, [&](Random& random) {
    const BlockStore blocks = nearly_parallel_blocks(random);
    const Matrix6 information = Matrix6::Identity() + 0.1 * random_prior(random);
    GreedyOracle<long double> oracle(blocks, information);
    InformationFactor factor = factor_of(information);
    for (std::size_t i = 0; i < 8; ++i) {
      add(factor, stored_block(blocks, i));
      oracle.take(i);
      expect_within_relative_error(factor, oracle);
    }
  });
}

// The sum of all candidates has the same bits on every instruction set, whatever lies beyond the last candidate.
TEST(InformationFactor, stays_within_its_relative_error_from_a_sum) {
  long double tightest = 0;
  for_every_family(300, [&](const BlockStore& blocks) {
    const std::size_t count = 293;
    const auto plane_count = std::size_t{6} * static_cast<std::size_t>(blocks.rows());
    const std::size_t stride = 304;
    std::vector<float> planes(plane_count * stride, std::numeric_limits<float>::quiet_NaN());
    std::vector<unsigned char> counted(count);
    GreedyOracle<long double> oracle(blocks);
    for (std::size_t i = 0; i < count; ++i) {
      counted[i] = blocks.is_valid(i) && i % 5 != 0 ? 1 : 0;
      if (counted[i] != 0) oracle.take(i);
      for (std::size_t p = 0; p < plane_count; ++p) {
        if (!blocks.is_valid(i)) continue;
        planes[p * stride + i] =
            planes_of(blocks).plane(static_cast<int>(p / 6), static_cast<int>(p % 6))[planes_of(blocks).place(i)];
      }
    }
    const std::vector<double> sum = same_on_every_kernel([&](const simd::Kernel& kernel) {
      std::vector<double> result(36);
      kernel.exact[blocks.rows() - 1].sum_information({planes.data(), stride}, counted.data(), count, result.data());
      return result;
    });
    const double roundings = simd::sum_roundings(count, blocks.rows());
    InformationFactor factor;
    const EigenPrior prior(default_information(blocks));
    ASSERT_TRUE(factor.reset(prior.data(), sum.data(), roundings));
    tightest = std::max(tightest, expect_within_relative_error(factor, oracle));
    const double of_determinant = factor.determinant_error(prior.data(), sum.data(), roundings);
    EXPECT_LE(std::abs(factor.prior_log_det() - oracle.log_det()) / 6, of_determinant + 1e-14L);
    EXPECT_LE(of_determinant, factor.relative_error());
    EXPECT_NEAR(factor.prior_log_det(), static_cast<double>(oracle.log_det()), 1e-6);
  });
  std::printf("largest deviation seen: %.2Le of its bound\n", tightest);
  EXPECT_GT(tightest, 0);
}

TEST(InformationFactor, knows_where_it_has_no_digits_left) {
  InformationFactor factor = factor_of(weak_information());
  EXPECT_LT(factor.relative_error(), 1e-10);
  Block row(1, 6);
  row << 1e13, -2e13, 3e12, 1e13, 5e12, -1e13;
  add(factor, row);
  EXPECT_GT(factor.relative_error(), 1);
}

}  // namespace
}  // namespace maxlogdet::test
