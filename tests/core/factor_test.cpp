// SPDX-License-Identifier: MIT
// The incremental factor and the bound of its error.
#include "tests/core/factors.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

// Expects (1 - f) M^-1 <= W^T W <= (1 + f) M^-1, with the triangle R of a QR decomposition of everything stacked, M =
// R^T R: the singular values of W R^T squared lie between.
void expect_within_relative_error(const InformationFactor& factor, const GreedyOracle<long double>& oracle) {
  EXPECT_TRUE(w_of(factor).isLowerTriangular());
  const WideMatrix ratio = wide_product(w_of(factor).cast<long double>(), oracle.factor().transpose());
  const WideVector6 squares = wide_eigenvalues(wide_gram(ratio.transpose()));
  EXPECT_LE(std::max(std::abs(squares(0) - 1), std::abs(squares(5) - 1)), factor.relative_error());
}

// The factor of the information and the oracle's, to which blocks are added in turn.
void expect_within_relative_error(const BlockStore& blocks, const Matrix6& information) {
  GreedyOracle<long double> oracle(blocks, information);
  InformationFactor factor = factor_of(information);
  expect_within_relative_error(factor, oracle);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks.is_valid(i)) continue;
    oracle.take(i);
    add(factor, stored_block(blocks, i));
    expect_within_relative_error(factor, oracle);
  }
}

// Eight blocks of long rows that are nearly parallel.
BlockStore nearly_parallel_blocks(Random& random) {
  const double scale = std::pow(10.0, random.uniform(0, 6));
  const double distance = std::pow(10.0, random.uniform(-6, 0));
  const Block direction = random_block(random, 1);
  return store_of(8, [&](std::size_t) {
    const int rows = random.integer(1, 3);
    const Block along = direction.colwise().replicate(rows);
    return Block(scale * (along + distance * random_block(random, rows)));
  });
}

TEST(InformationFactor, stays_within_its_relative_error) {
  for_every_family(
      40, [&](const BlockStore& blocks) { expect_within_relative_error(blocks, default_information(blocks)); });
  for_each_trial(1000, [&](Random& random) {
    const Matrix6 information = Matrix6::Identity() + 0.1 * random_prior(random);
    expect_within_relative_error(nearly_parallel_blocks(random), information);
  });
}

// The sum of all candidates is the same on every instruction set, whatever lies beyond the last candidate.
TEST(InformationFactor, stays_within_its_relative_error_from_a_sum) {
  for_every_family(300, [&](const BlockStore& blocks) {
    const std::size_t count = 293, stride = 304;
    const auto plane_count = std::size_t{6} * static_cast<std::size_t>(blocks.rows());
    std::vector<float> planes(plane_count * stride, static_cast<float>(nan));
    std::vector<unsigned char> counted(count);
    GreedyOracle<long double> oracle(blocks);
    for (std::size_t i = 0; i < count; ++i) {
      counted[i] = blocks.is_valid(i) && i % 5 != 0 ? 1 : 0;
      if (counted[i] != 0) oracle.take(i);
      if (!blocks.is_valid(i)) continue;
      const Block block = stored_block(blocks, i);
      for (std::size_t p = 0; p < plane_count; ++p) planes[p * stride + i] = static_cast<float>(block.data()[p]);
    }
    std::vector<double> sum;
    for (const simd::Kernel* const kernel : supported_kernels()) {
      std::vector<double> result(36);
      kernel->exact[blocks.rows() - 1].sum_information({planes.data(), stride}, counted.data(), count, result.data());
      if (sum.empty()) sum = result;
      EXPECT_EQ(result, sum) << kernel->isa;
    }
    const double roundings = simd::sum_roundings(count, blocks.rows());
    InformationFactor factor;
    const EigenPrior prior(default_information(blocks));
    ASSERT_TRUE(factor.reset(prior.data(), sum.data(), roundings));
    expect_within_relative_error(factor, oracle);
    const double of_determinant = factor.determinant_error(prior.data(), sum.data(), roundings);
    EXPECT_LE(std::abs(factor.prior_log_det() - oracle.log_det()) / 6, of_determinant + 1e-14L);
    EXPECT_LE(of_determinant, factor.relative_error());
    EXPECT_NEAR(factor.prior_log_det(), static_cast<double>(oracle.log_det()), 1e-6);
  });
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
