// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"
#include "simd/kernel.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <vector>

// What tests know of the library's factor of the information and of its kernels.

namespace maxlogdet::test {

/// A block's rows as the library passes them.
struct Rows {
  explicit Rows(const Block& block) {
    for (int row = 0; row < block.rows(); ++row) {
      for (int column = 0; column < state_dimension; ++column) entries[row][column] = block(row, column);
    }
  }
  double entries[max_block_rows][state_dimension] = {};
};

/// With a prior.
inline InformationFactor factor_of(const Matrix6& information) {
  InformationFactor factor;
  const EigenPrior prior(information);
  EXPECT_TRUE(factor.reset(prior.data()));
  return factor;
}

inline void add(InformationFactor& factor, const Block& block) {
  factor.add_block(*simd::built_in()[0], Rows(block).entries, static_cast<int>(block.rows()));
}

/// Expects of(kernel), numbers, to have the same bits on every instruction set, and returns it.
template <class Function>
std::vector<double> same_on_every_kernel(const Function& of) {
  const std::vector<double> expected = of(*supported_kernels().front());
  for (const simd::Kernel* const kernel : supported_kernels()) {
    const std::vector<double> numbers = of(*kernel);
    EXPECT_TRUE(std::equal(numbers.begin(), numbers.end(), expected.begin(), expected.end(), [](double a, double b) {
      return bits_of(a) == bits_of(b);
    })) << kernel->isa;
  }
  return expected;
}

}  // namespace maxlogdet::test
