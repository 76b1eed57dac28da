// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <cmath>

namespace maxlogdet::test {

/// Information as the upper triangle R of a QR decomposition, R^T R = M0 + sum h^T h: adding up the h^T h themselves
/// would square the condition number. Rows are added one by one by Givens rotations, some hundred operations each, so
/// that a test can try millions of subsets. Unlike a decomposition by Householder, this keeps small rows beside large
/// ones: in long double it is exact where the information spreads over 50 decades.
template <class Scalar>
class TriangleOf {
 public:
  /// From the lower triangle of a symmetric positive definite prior.
  explicit TriangleOf(const Matrix6& prior) {
    for (int i = 0; i < state_dimension; ++i) {  // R^T is the lower Cholesky factor
      for (int j = 0; j <= i; ++j) {
        Scalar sum = static_cast<Scalar>(prior(i, j));
        for (int d = 0; d < j; ++d) sum -= r_[d][i] * r_[d][j];
        r_[j][i] = i == j ? std::sqrt(sum) : sum / r_[j][j];
      }
    }
  }

  /// M <- M + h^T h, h: state_dimension entries.
  template <class Entry>
  void add_row(const Entry* row) {
    Scalar rest[state_dimension];
    for (int d = 0; d < state_dimension; ++d) rest[d] = static_cast<Scalar>(row[d]);
    for (int j = 0; j < state_dimension; ++j) {
      if (rest[j] == 0) continue;
      const Scalar length = std::sqrt(r_[j][j] * r_[j][j] + rest[j] * rest[j]);
      const Scalar cosine = r_[j][j] / length;
      const Scalar sine = rest[j] / length;
      r_[j][j] = length;
      for (int d = j + 1; d < state_dimension; ++d) {
        const Scalar of_triangle = r_[j][d];
        r_[j][d] = cosine * of_triangle + sine * rest[d];
        rest[d] = cosine * rest[d] - sine * of_triangle;
      }
    }
  }

  void add(const Block& block) {
    for (int row = 0; row < block.rows(); ++row) add_row(block.row(row).data());
  }

  /// sqrt(det M): monotonic in log det, without a logarithm. In long double finite for any float32 blocks.
  Scalar volume() const {
    Scalar product = 1;
    for (int i = 0; i < state_dimension; ++i) product *= r_[i][i];
    return product;
  }

  /// log det M, nats, and how much it exceeds another.
  Scalar log_det() const {
    Scalar sum = 0;
    for (int i = 0; i < state_dimension; ++i) sum += 2 * std::log(r_[i][i]);
    return sum;
  }
  Scalar log_det_over(const TriangleOf& other) const {
    Scalar sum = 0;
    for (int i = 0; i < state_dimension; ++i) sum += 2 * std::log(r_[i][i] / other.r_[i][i]);
    return sum;
  }

  Scalar entry(int row, int column) const { return r_[row][column]; }

 private:
  Scalar r_[state_dimension][state_dimension] = {};
};

using Triangle = TriangleOf<long double>;

}  // namespace maxlogdet::test
