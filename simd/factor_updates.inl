// SPDX-License-Identifier: MIT
// Rank-one updates of the inverse factor in float64, the same bits on every instruction set: nothing
// fused, and sums in one order.

namespace maxlogdet::simd {
namespace {

// y = W h^T.
inline void whiten_row(const double* w, const double* h, double (&y)[dimension]) {
#pragma GCC unroll 6
  for (int i = 0; i < dimension; ++i) {
    y[i] = w[padded_dimension * i] * h[0];
#pragma GCC unroll 6
    for (int d = 1; d <= i; ++d) y[i] += w[padded_dimension * i + d] * h[d];
  }
}

// W_i  <-  sqrt(s_{i-1} / s_i) (W_i - y_i / s_{i-1} c_{i-1}),  c_i = y_0 W_0 + ... + y_i W_i; s[i] is s_{i-1}.
inline void update_factor_rows(double* w, const double (&y)[dimension], const double (&s)[dimension + 1]) {
  constexpr int n = dimension;
  // By pairs: the latency of six divisions and roots one by one would dominate an update.
  alignas(TwoDoubles) double scale[n];
  alignas(TwoDoubles) double factor[n];
#pragma GCC unroll 3
  for (int i = 0; i < n; i += 2) {
    const TwoDoubles before = pair(s[i], s[i + 1]);
    xsimd::sqrt(before / pair(s[i + 1], s[i + 2])).store_aligned(scale + i);
    (pair(y[i], y[i + 1]) / before).store_aligned(factor + i);
  }
  // Whole rows, zeros above the diagonal included: the next vector load of a row would stall on stores of single
  // entries.
  constexpr std::size_t packs = padded_dimension / double_lanes;
  Doubles c[packs];
  for (Doubles& pack : c) pack = Doubles(0.0);
#pragma GCC unroll 6
  for (int i = 0; i < n; ++i) {
    double* const row = w + padded_dimension * i;
#pragma GCC unroll 4
    for (std::size_t p = 0; p < packs; ++p) {
      const Doubles entry = Doubles::load_unaligned(row + p * double_lanes);
      (Doubles(scale[i]) * (entry - Doubles(factor[i]) * c[p])).store_unaligned(row + p * double_lanes);
      c[p] += Doubles(y[i]) * entry;
    }
  }
}

// With y = W h^T, M + h^T h = L (I + y y^T) L^T, and the Cholesky factor of I + y y^T has a closed form, with s_i = 1 +
// y_0^2 + ... + y_i^2. Its inverse is applied to W row by row. It takes products and square roots of positive numbers
// only, and cannot break down, however large h is.
inline double add_row(double* w, const double* h) {
  double y[dimension];
  whiten_row(w, h, y);
  double s[dimension + 1] = {1};
  double relative_gain = 0;  // s - 1, with all its digits
#pragma GCC unroll 6
  for (int i = 0; i < dimension; ++i) {
    relative_gain += y[i] * y[i];
    s[i + 1] = s[i] + y[i] * y[i];
  }
  update_factor_rows(w, y, s);
  return relative_gain;
}

double add_rows(double* w, const double* rows, int count, float* narrow) {
  double relative_gain = 0;
  for (int row = 0; row < count; ++row, rows += dimension) {
    const double of_row = add_row(w, rows);
    relative_gain += of_row + relative_gain * of_row;  // (1 + relative gain) (1 + of_row) - 1
  }
  for (std::size_t i = 0; i < std::size_t{dimension} * padded_dimension; i += double_lanes) {
    store_narrow(Doubles::load_unaligned(w + i), narrow + i);
  }
  return relative_gain;
}

}  // namespace
}  // namespace maxlogdet::simd
