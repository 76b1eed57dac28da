// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>

namespace maxlogdet {

/// The information M = prior + sum of h^T h over the rows added, kept as the inverse W = L^-1 of its Cholesky factor
/// M = L L^T, so that a candidate's gain needs no solve: Y = H L^-T = H W^T.
class InformationFactor {
 public:
  static constexpr int n = state_dimension;

  /// Starts from a prior, 6 x 6 row-major; nullptr: 1e-5 * I. False if it is not finite, symmetric and safely positive
  /// definite (docs/numerics.md).
  bool reset(const double* prior) noexcept;

  /// M <- M + h^T h for a 1 x 6 row, in O(n^2).
  void add_row(const double* row) noexcept;

  /// W, n x n row-major, lower triangular.
  const double* inverse() const noexcept { return &w_[0][0]; }

  /// log det M of the prior, nats.
  double prior_log_det() const noexcept { return prior_log_det_; }

  /// Bound of the rounding error of a gain computed from W, in nats, for blocks whose rows have at most this norm:
  /// |computed - exact| <= gain_error. Infinite where W has no digits to offer. Derived in docs/numerics.md.
  double gain_error(double max_row_norm) const noexcept;

 private:
  double inverse_norm() const noexcept;  // Frobenius norm of W

  double w_[n][n];
  double trace_;           // of M
  double relative_error_;  // f: (1 - f) M^-1 <= W^T W <= (1 + f) M^-1, in the order of symmetric matrices
  double prior_log_det_;
};

}  // namespace maxlogdet
