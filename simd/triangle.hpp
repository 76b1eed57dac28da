// SPDX-License-Identifier: MIT
#pragma once

#include "simd/camera_models.hpp"

// Rows rotated among themselves to a triangle: of packs for blocks, of a double for the weight of a match. C++14, as
// kernel/.

namespace maxlogdet::simd {
namespace {

/// A block is A [ I | -[p]x ], with an upper triangular A: its rows are those of the measurements after a rotation
/// among them, which changes no gain, and keeps them from being nearly parallel (as u and u_right are).
template <class Number, int Rows>
struct FactorOf {
  static_assert(Rows == 2 || Rows == 3, "a residual has two rows, or three");
  Number a[Rows][3];  // not read below the diagonal
};

/// Rotates rows a and b, so that b has a zero in `column`, and a what is not negative.
template <class Number>
inline void rotate_rows(int column, Number (&a)[3], Number (&b)[3]) {
  const Number zero(0.0);
  const Number norm = sqrt(a[column] * a[column] + b[column] * b[column]);
  const ConditionOf<Number> is_nonzero = norm > zero;
  const Number cosine = select(is_nonzero, a[column] / norm, Number(1.0));
  const Number sine = select(is_nonzero, b[column] / norm, zero);
  a[column] = norm;
  for (int j = column + 1; j < 3; ++j) {
    const Number kept = a[j];
    a[j] = cosine * kept + sine * b[j];
    b[j] = cosine * b[j] - sine * kept;
  }
}

/// An upper triangular A = Q rows.
template <class Number, int Rows>
inline FactorOf<Number, Rows> triangle_of(Number (&rows)[Rows][3]) {
  rotate_rows(0, rows[0], rows[1]);
  if (Rows == 3) {
    rotate_rows(0, rows[0], rows[Rows - 1]);
    rotate_rows(1, rows[1], rows[Rows - 1]);
  }
  FactorOf<Number, Rows> factor;
  for (int a = 0; a < Rows; ++a) {
    for (int j = a; j < 3; ++j) factor.a[a][j] = rows[a][j];
  }
  return factor;
}

}  // namespace
}  // namespace maxlogdet::simd
