// SPDX-License-Identifier: MIT
// The products of whitened rows.

namespace {

// Y Y^T, its upper triangle by rows, with Y = H W^T, column by column of Y: a longer chain of dependent operations than
// row by row, but half of the registers. `load(e)` is entry e of a pack of blocks; multiply_add(x, y, z) is x y + z.
template <int Rows, class Pack, class Load, class Number, class MultiplyAdd>
inline void products_of_whitened(const Load& load, const Number* w, const MultiplyAdd& multiply_add,
                                 Pack (&products)[Rows * (Rows + 1) / 2]) {
  Pack h[Rows][dimension];
  for (int a = 0; a < Rows; ++a) {
    for (int d = 0; d < dimension; ++d) h[a][d] = load(static_cast<std::size_t>(dimension * a + d));
  }
#pragma GCC unroll 6
  for (int c = 0; c < dimension; ++c) {
    Pack y[Rows];
#pragma GCC unroll 6
    for (int d = 0; d <= c; ++d) {
      const Pack weight(w[padded_dimension * c + d]);
      for (int a = 0; a < Rows; ++a) y[a] = d == 0 ? weight * h[a][0] : multiply_add(weight, h[a][d], y[a]);
    }
    for (int a = 0, e = 0; a < Rows; ++a) {
      for (int b = a; b < Rows; ++b, ++e) products[e] = c == 0 ? y[a] * y[b] : multiply_add(y[a], y[b], products[e]);
    }
  }
}

}  // namespace
