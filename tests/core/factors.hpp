// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"
#include "simd/kernel.hpp"
#include "tests/support/support.hpp"

#include <algorithm>

// What tests know of the library's factor of the information and of its kernels.

namespace maxlogdet::test {

/// With a prior.
inline InformationFactor factor_of(const Matrix6& information) {
  InformationFactor factor;
  const EigenPrior prior(information);
  EXPECT_TRUE(factor.reset(prior.data()));
  return factor;
}

inline void add(InformationFactor& factor, const Block& block) {
  double rows[max_block_rows][state_dimension] = {};
  for (int row = 0; row < block.rows(); ++row) std::copy_n(block.row(row).data(), state_dimension, rows[row]);
  factor.add_block(*simd::built_in()[0], rows, static_cast<int>(block.rows()));
}

/// W.
inline Matrix6 w_of(const InformationFactor& factor) {
  Matrix6 w;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) w(i, j) = factor.inverse()[simd::padded_dimension * i + j];
  }
  return w;
}

}  // namespace maxlogdet::test
