// SPDX-License-Identifier: MIT
// The triangle that exhaustive search and the limits rest on, against a QR decomposition by Eigen.
#include "tests/support/triangle.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

TEST(Triangle, is_that_of_eigens_qr) {
  static constexpr long double rounding = 1e3L * std::numeric_limits<long double>::epsilon();
  for_each_trial(300, [](Random& random) {
    const Matrix6 prior = random.chance(0.5) ? random_prior(random) : weak_information();
    Triangle triangle(prior);
    WideRows stack = WideRows::Zero(6, 6);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) stack(i, j) = triangle.entry(i, j);
    }
    for (int i = random.integer(0, 20); i > 0; --i) {
      const Block block = random_block(random, random.integer(1, 3), std::pow(10.0, random.uniform(-1, 1)));
      triangle.add(block);
      stack.conservativeResize(stack.rows() + block.rows(), state_dimension);
      stack.bottomRows(block.rows()) = block.cast<long double>();
    }
    EXPECT_LE((stack.topRows<6>().transpose() * stack.topRows<6>() - prior.cast<long double>()).norm(),
              1e3L * rounding);
    const WideSquare r = triangle_of(stack);
    long double log_det = 0;
    for (int i = 0; i < state_dimension; ++i) {
      log_det += 2 * std::log(std::abs(r(i, i)));
      for (int j = i; j < state_dimension; ++j) {
        const long double expected = r(i, i) < 0 ? -r(i, j) : r(i, j);
        EXPECT_NEAR(static_cast<double>((triangle.entry(i, j) - expected) / r.col(j).norm()), 0,
                    static_cast<double>(rounding * r.col(j).norm() / std::abs(r(i, i))))
            << i << ' ' << j;
      }
    }
    EXPECT_LE(std::abs(triangle.log_det() - log_det), 1e3L * rounding);
  });
}

}  // namespace
}  // namespace maxlogdet::test
