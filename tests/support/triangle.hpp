// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {

/// Information as the upper triangle R of a QR decomposition, R^T R = M0 + sum h^T h, in long double: adding up the
/// h^T h themselves would square the condition number. Rows are added one by one by Givens rotations, some
/// hundred operations each, so that a test can try millions of subsets.
class Triangle {
 public:
  /// From the lower triangle of a symmetric positive definite prior.
  explicit Triangle(const Matrix6& prior) {
    for (int i = 0; i < state_dimension; ++i) {  // R^T is the lower Cholesky factor
      for (int j = 0; j <= i; ++j) {
        long double sum = prior(i, j);
        for (int d = 0; d < j; ++d) sum -= r_[d][i] * r_[d][j];
        r_[j][i] = i == j ? std::sqrt(sum) : sum / r_[j][j];
      }
    }
  }

  /// M <- M + h^T h, h: state_dimension entries.
  void add_row(const long double* row) {
    long double rest[state_dimension];
    std::copy_n(row, state_dimension, rest);
    for (int j = 0; j < state_dimension; ++j) {
      if (rest[j] == 0) continue;
      const long double length = std::sqrt(r_[j][j] * r_[j][j] + rest[j] * rest[j]);
      const long double cosine = r_[j][j] / length;
      const long double sine = rest[j] / length;
      r_[j][j] = length;
      for (int d = j + 1; d < state_dimension; ++d) {
        const long double of_triangle = r_[j][d];
        r_[j][d] = cosine * of_triangle + sine * rest[d];
        rest[d] = cosine * rest[d] - sine * of_triangle;
      }
    }
  }

  void add(const Block& block) {
    for (int row = 0; row < block.rows(); ++row) {
      long double entries[state_dimension];
      for (int d = 0; d < state_dimension; ++d) entries[d] = block(row, d);
      add_row(entries);
    }
  }

  /// sqrt(det M): monotonic in log det, without a logarithm. Finite for any float32 blocks.
  long double volume() const {
    long double product = 1;
    for (int i = 0; i < state_dimension; ++i) product *= r_[i][i];
    return product;
  }

  /// log det M, nats.
  long double log_det() const { return 2 * std::log(volume()); }

  long double entry(int row, int column) const { return r_[row][column]; }

 private:
  long double r_[state_dimension][state_dimension] = {};
};

}  // namespace maxlogdet::test
