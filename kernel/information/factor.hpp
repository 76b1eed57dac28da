// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstdint>

namespace maxlogdet {

/// The error f from which on it no longer bounds gains.
constexpr double hopeless_error = 0.125;
/// Values of the exact information and of a factor of error f differ by at most this times f, relative and per row
/// (docs/numerics.md).
constexpr double drift_of_error = 2.5;

/// Sets l to the lower Cholesky factor of a symmetric matrix, 6 x 6 row-major, of which the lower triangle is read.
/// False if a pivot is not above that share of its diagonal entry, and is thus rounding, not information.
bool cholesky(const double* matrix, double smallest_pivot, double (&l)[state_dimension][state_dimension]) noexcept;

/// Upper bounds of |y|^2 for any whitened row y = W h, given the maximum |entry| of each column of H.
struct WhitenedRowBounds {
  double squares;    ///< | |W| d |^2, d the column maxima
  double frobenius;  ///< |W diag(d)|_F^2: at least 1/6 of `squares`; never increases as rows are added
};

/// The information M = prior + sum of h^T h over the rows added, kept as the inverse W = L^-1 of its Cholesky factor
/// M = L L^T, so that a candidate's gain needs no solve: Y = H L^-T = H W^T. Norms are taken in units of the
/// directions, powers of two near the roots of the prior's diagonal: no bound depends on the caller's units.
class InformationFactor {
 public:
  static constexpr int n = state_dimension;

  /// Starts from a symmetric prior, 6 x 6 row-major. False if it is not safely positive definite (docs/numerics.md).
  bool reset(const double* prior) noexcept;

  /// M <- M + H^T H, `count` rows of H one by one, each in O(n^2). Returns the relative gain of det M.
  double add_block(const simd::Kernel& kernel, const double (*rows)[n], int count) noexcept;

  /// W, n x 8 row-major, lower triangular.
  const double* inverse() const noexcept { return &w_[0][0]; }

  /// W, rounded to float32.
  const float* narrow_inverse() const noexcept { return &narrow_[0][0]; }

  /// log det M of the prior, nats.
  double prior_log_det() const noexcept { return prior_log_det_; }

  /// f, an upper bound of the error of W: (1 - f) M^-1 <= W^T W <= (1 + f) M^-1 in the order of symmetric matrices.
  /// Derived in docs/numerics.md.
  double relative_error() const noexcept { return relative_error_; }

  /// |Entries| of W count as at least simd::smallest_entry.
  WhitenedRowBounds bound_rows(const double* column_max) const noexcept;

  /// The Frobenius norm of W, in units.
  double inverse_norm() const noexcept;

 private:
  void narrow() noexcept;

  double w_[n][simd::padded_dimension];
  float narrow_[n][simd::padded_dimension];
  double unit_[simd::padded_dimension];  // of each direction, a power of two
  double per_unit_[n];
  double norm_;            // of W, or an upper bound of it
  std::uint32_t added_;    // blocks since the last reset
  double trace_;           // of M, in units
  double relative_error_;  // f
  double prior_log_det_;
};

}  // namespace maxlogdet
