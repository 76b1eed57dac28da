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
  double s[n + 1] = {1};
  double growth = 0;  // s - 1, with all its digits
#pragma GCC unroll 6
  for (int i = 0; i < n; ++i) {
    growth += y[i] * y[i];
    s[i + 1] = s[i] + y[i] * y[i];
  }
  // By pairs: dividing and taking roots one by one is what an update would wait for.
  alignas(TwoDoubles) double scale[n];
  alignas(TwoDoubles) double factor[n];
#pragma GCC unroll 3
  for (int i = 0; i < n; i += 2) {
    const TwoDoubles before = pair(s[i], s[i + 1]);
    xsimd::sqrt(before / pair(s[i + 1], s[i + 2])).store_aligned(scale + i);
    (pair(y[i], y[i + 1]) / before).store_aligned(factor + i);
  }
  double c[n] = {};
#pragma GCC unroll 6
  for (int i = 0; i < n; ++i) {
    double* const row = w + padded * i;
#pragma GCC unroll 6
    for (int d = 0; d <= i; ++d) {
      const double entry = row[d];
      row[d] = scale[i] * (entry - factor[i] * c[d]);
      c[d] += y[i] * entry;
    }
  }
  return growth;
}

}  // namespace
