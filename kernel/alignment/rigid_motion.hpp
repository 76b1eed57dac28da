// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/inputs.hpp>

namespace maxlogdet {

/// A pose and how far it has moved from where it started, by + - * / alone: the same bits on every machine.
class RigidMotion {
 public:
  /// Starts at a pose, whose rotation is made orthonormal: as a tracker has it, perhaps in float32, it is nearly so.
  void start(const RigidTransform& T) noexcept;
  /// T <- exp(xi^) T up to the third order, by Cayley's rotation; xi = (translation, rotation).
  void move(const double (&xi)[6]) noexcept;
  /// T, 3 x 4 row-major, now and at the start.
  const double* pose() const noexcept { return T_; }
  const double* start_pose() const noexcept { return start_; }
  /// Adds a prior about the start, 6 x 6 information, to the normal equations H x = b of a step. Its term of the
  /// objective is xi^T prior xi. With T = D T_start and D = [R | t], xi is t and the vector of (R - R^T) / 2, which is
  /// the logarithm of D up to the third order.
  void add_prior(const double* prior, double (&H)[6][6], double (&b)[6]) const noexcept;

 private:
  double T_[12], start_[12];
};

/// Solves H x = b of a symmetric H, of which the lower triangle is read. False where it is not positive definite, or so
/// nearly singular, whatever the units of its rows, that x has next to no digits.
bool solve(const double (&H)[6][6], const double (&b)[6], double (&x)[6]) noexcept;

}  // namespace maxlogdet
