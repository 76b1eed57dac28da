// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/inputs.hpp>

#include <algorithm>
#include <cstddef>

namespace maxlogdet {

/// A pose and how far it has moved from where it started, by + - * / alone: the same bits on every machine.
class RigidMotion {
 public:
  /// Starts at a pose, whose rotation is made orthonormal: as a tracker has it, perhaps in float32, it is nearly so.
  void start(const RigidTransform& T) noexcept {
    std::copy_n(T.data(), 12, T_);
    // R <- (3 R - R R^T R) / 2, a step of Newton's method to the nearest rotation, squares the error: one suffices for
    // float32.
    for (int steps = T.rotation_error() > 1e-6 ? 2 : 1; steps > 0; --steps) {
      double from[12];
      std::copy_n(T_, 12, from);
      for (std::size_t i = 0; i < 3; ++i) {
        double dots[3];  // R_i R_j
        for (std::size_t j = 0; j < 3; ++j) {
          dots[j] = from[4 * i] * from[4 * j] + from[4 * i + 1] * from[4 * j + 1] + from[4 * i + 2] * from[4 * j + 2];
        }
        for (std::size_t k = 0; k < 3; ++k) {
          const double cubed = dots[0] * from[k] + dots[1] * from[4 + k] + dots[2] * from[8 + k];
          T_[4 * i + k] = 1.5 * from[4 * i + k] - 0.5 * cubed;
        }
      }
    }
    std::copy_n(T_, 12, start_);
  }

  /// T <- exp(xi^) T up to the third order, by Cayley's rotation; xi = (translation, rotation).
  void move(const double (&xi)[6]) noexcept {
    const double a[3] = {xi[3] / 2, xi[4] / 2, xi[5] / 2};
    const double squared = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    const double c = 2 / (1 + squared);
    double R[3][3];  // I + c ([a]x + [a]x^2), [a]x^2 = a a^T - |a|^2 I
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) R[i][j] = c * a[i] * a[j] + (i == j ? 1 - c * squared : 0);
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const int k = (i + 2) % 3;
      R[k][j] += c * a[i];
      R[j][k] -= c * a[i];
    }
    double from[12];
    std::copy_n(T_, 12, from);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 4; ++j)
        T_[4 * i + j] = R[i][0] * from[j] + R[i][1] * from[4 + j] + R[i][2] * from[8 + j] + (j == 3 ? xi[i] : 0);
    }
  }

  /// T, 3 x 4 row-major, now and at the start.
  const double* pose() const noexcept { return T_; }
  const double* start_pose() const noexcept { return start_; }

  /// Adds a prior about the start, 6 x 6 information, to the normal equations H x = b of a step. Its term of the
  /// objective is xi^T prior xi. With T = D T_start and D = [R | t], xi is t and the vector of (R - R^T) / 2, which is
  /// the logarithm of D up to the third order.
  void add_prior(const double* prior, double (&H)[6][6], double (&b)[6]) const noexcept {
    double R[3][3], t[3];
    for (std::size_t i = 0; i < 3; ++i) {
      t[i] = T_[4 * i + 3];
      for (std::size_t j = 0; j < 3; ++j) {
        R[i][j] = T_[4 * i] * start_[4 * j] + T_[4 * i + 1] * start_[4 * j + 1] + T_[4 * i + 2] * start_[4 * j + 2];
        t[i] -= R[i][j] * start_[4 * j + 3];
      }
    }
    const double xi[6] = {t[0], t[1], t[2], (R[2][1] - R[1][2]) / 2, (R[0][2] - R[2][0]) / 2, (R[1][0] - R[0][1]) / 2};
    double G[6][6] = {};
    const double trace = R[0][0] + R[1][1] + R[2][2];
    for (int i = 0; i < 3; ++i) {
      G[i][i] = 1;
      G[i][3 + (i + 1) % 3] = t[(i + 2) % 3];
      G[i][3 + (i + 2) % 3] = -t[(i + 1) % 3];
      for (int j = 0; j < 3; ++j) G[3 + i][3 + j] = ((i == j ? trace : 0) - R[i][j]) / 2;
    }
    for (int i = 0; i < 6; ++i) {
      double of_column[6] = {};  // row i of G^T prior
      for (int j = 0; j < 6; ++j) {
        for (int k = 0; k < 6; ++k) of_column[j] += G[k][i] * prior[6 * k + j];
      }
      for (int j = 0; j < 6; ++j) {
        for (int k = 0; k < 6; ++k) H[i][j] += of_column[k] * G[k][j];
        b[i] -= of_column[j] * xi[j];
      }
    }
  }

 private:
  double T_[12], start_[12];
};

}  // namespace maxlogdet
