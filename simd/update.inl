// SPDX-License-Identifier: MIT
// The rank-one update of the inverse factor in float64, the same bits on every instruction set: nothing
// fused, and sums in one order.

namespace {

// With y = W h^T, M + h^T h = L (I + y y^T) L^T, and the Cholesky factor of I + y y^T has a closed form. Its inverse,
// applied to W row by row, with s_i = 1 + y_0^2 + ... + y_i^2 and c_i = y_0 W_0 + ... + y_i W_i:
//
//   W_i  <-  sqrt(s_{i-1} / s_i) (W_i - y_i / s_{i-1} c_{i-1}).
//
// Products and square roots of positive numbers only: it cannot break down, however large h is.
double add_row(double* w, const double* h) {
  constexpr int n = dimension;
  constexpr int padded = padded_dimension;
  double y[n];
#pragma GCC unroll 6
  for (int i = 0; i < n; ++i) {
    y[i] = w[padded * i] * h[0];
#pragma GCC unroll 6
    for (int d = 1; d <= i; ++d) y[i] += w[padded * i + d] * h[d];
  }
  double s = 1;
  double growth = 0;  // s - 1, with all its digits
  double c[n] = {};
#pragma GCC unroll 6
  for (int i = 0; i < n; ++i) {
    growth += y[i] * y[i];
    const double s_next = s + y[i] * y[i];
    const double scale = __builtin_sqrt(s / s_next);
    const double factor = y[i] / s;
    double* const row = w + padded * i;
#pragma GCC unroll 6
    for (int d = 0; d <= i; ++d) {
      const double entry = row[d];
      row[d] = scale * (entry - factor * c[d]);
      c[d] += y[i] * entry;
    }
    s = s_next;
  }
  return growth;
}

}  // namespace
