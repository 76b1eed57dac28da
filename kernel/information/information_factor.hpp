// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstdint>

namespace maxlogdet {

/// M0 = 1e-5 I where there is no other prior.
constexpr double default_prior_information = 1e-5;

/// f, InformationFactor::relative_error(), above which a factor that rows have left is made anew, if that helps.
constexpr double large_error = 1e-6;
/// f from which on it says nothing about gains any more.
constexpr double hopeless_error = 0.125;

/// The information M = prior + sum of h^T h over the rows added, kept as the inverse W = L^-1 of its Cholesky factor
/// M = L L^T, so that a candidate's gain needs no solve: Y = H L^-T = H W^T.
class InformationFactor {
 public:
  static constexpr int n = state_dimension;

  /// Starts from a prior, 6 x 6 row-major; nullptr: 1e-5 * I. False if it is not finite, symmetric and safely positive
  /// definite (docs/numerics.md).
  bool reset(const double* prior) noexcept { return reset(prior, nullptr, 0); }

  /// The same from prior + added, where a sum of H^T H is off by at most `roundings` 2^-53 sqrt(M_ii M_jj) in an entry.
  /// prior_log_det() is then that of both.
  bool reset(const double* prior, const double* added, double roundings) noexcept;

  /// Right after that, how far the sixth root of det M can be off, relatively: relative_error() is larger where
  /// directions have units of unlike size, which the determinant does not notice.
  double determinant_error(const double* prior, const double* added, double roundings) const noexcept;

  /// M <- M + H^T H, `count` rows of H one by one, each in O(n^2). Returns the relative gain of det M.
  double add_block(const simd::Kernel& kernel, const double (*rows)[n], int count) noexcept;

  /// M <- M - H^T H, for rows that were added. False if too few digits would be left of what remains, or if that is not
  /// positive definite: then nothing is known of M any more, and the caller starts again, with reset or a copy, and
  /// adds what is left. relative_error() may have grown a lot; that heals it too.
  bool remove_block(const simd::Kernel& kernel, const double (*rows)[n], int count) noexcept;

  /// W, n x 8 row-major, lower triangular.
  const double* inverse() const noexcept { return &w_[0][0]; }

  /// The same, rounded to float32.
  const float* narrow_inverse() const noexcept { return &narrow_[0][0]; }

  /// log det M of the prior, nats.
  double prior_log_det() const noexcept { return prior_log_det_; }

  /// f, a bound of how far W is from the exact inverse factor: (1 - f) M^-1 <= W^T W <= (1 + f) M^-1 in the order of
  /// symmetric matrices. Derived in docs/numerics.md.
  double relative_error() const noexcept { return relative_error_; }

  /// The Frobenius norm of W.
  double inverse_norm() const noexcept;

 private:
  void narrow() noexcept;

  double w_[n][simd::padded_dimension];
  float narrow_[n][simd::padded_dimension];
  double norm_;            // of W, or above it
  std::uint32_t added_;    // blocks since it was taken anew
  double trace_;           // of M, or above it: of all rows that were ever added
  double relative_error_;  // f
  double prior_log_det_;
};

}  // namespace maxlogdet
