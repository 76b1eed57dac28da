// SPDX-License-Identifier: MIT
#include "kernel/alignment/rigid_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace maxlogdet {
namespace {

// A pivot of Cholesky's factorisation below this share of its diagonal entry is rounding, not information.
constexpr double smallest_relative_pivot = 1e-12;

// to <- [R | t] from, as rigid transforms.
void compose(const double (&R)[3][3], const double (&t)[3], double (&T)[12]) noexcept {
  double product[12];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) {
      product[4 * i + j] = R[i][0] * T[j] + R[i][1] * T[4 + j] + R[i][2] * T[8 + j] + (j == 3 ? t[i] : 0);
    }
  }
  std::copy_n(product, 12, T);
}

}  // namespace

// R <- (3 R - R R^T R) / 2, a step of Newton's method to the nearest rotation, squares the error: one suffices for
// float32.
void RigidMotion::start(const RigidTransform& T) noexcept {
  std::copy_n(T.data(), 12, T_);
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

void RigidMotion::move(const double (&xi)[6]) noexcept {
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
  compose(R, {xi[0], xi[1], xi[2]}, T_);
}

// The derivative of xi by a step from the left is [I, -[t]x; 0, (tr(R) I - R) / 2].
void RigidMotion::add_prior(const double* prior, double (&H)[6][6], double (&b)[6]) const noexcept {
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

bool solve(const double (&H)[6][6], const double (&b)[6], double (&x)[6]) noexcept {
  double L[6][6];
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = H[i][j];
      for (int k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      if (i == j && !(sum > smallest_relative_pivot * H[i][i])) return false;
      L[i][j] = i == j ? std::sqrt(sum) : sum / L[j][j];
    }
  }
  for (int i = 0; i < 6; ++i) {
    x[i] = b[i];
    for (int k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] /= L[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
  return std::all_of(x, x + 6, [](double entry) { return std::isfinite(entry); });
}

}  // namespace maxlogdet
