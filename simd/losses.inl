// SPDX-License-Identifier: MIT
// Relative losses in float64, the same bits on every instruction set: additions and multiplications only, none fused.

namespace {

// Consecutive floats as doubles.
inline Doubles widened(const float* values) {
  Narrow narrow;
  std::memcpy(&narrow, values, sizeof narrow);
  return Doubles(__builtin_convertvector(narrow, Doubles::register_type));
}

// Y Y^T, its upper triangle by rows, with Y = H W^T, column by column of Y.
template <int Rows>
inline void products_of_whitened(const float* entries, std::size_t stride, const double* w,
                                 Doubles (&products)[Rows * (Rows + 1) / 2]) {
  Doubles h[Rows][dimension];
  for (int a = 0; a < Rows; ++a) {
    for (int d = 0; d < dimension; ++d)
      h[a][d] = widened(entries + static_cast<std::size_t>(dimension * a + d) * stride);
  }
#pragma GCC unroll 6
  for (int c = 0; c < dimension; ++c) {
    Doubles y[Rows];
#pragma GCC unroll 6
    for (int d = 0; d <= c; ++d) {
      const Doubles weight(w[padded_dimension * c + d]);
      for (int a = 0; a < Rows; ++a) y[a] = d == 0 ? weight * h[a][0] : y[a] + weight * h[a][d];
    }
    for (int a = 0, e = 0; a < Rows; ++a) {
      for (int b = a; b < Rows; ++b, ++e) products[e] = c == 0 ? y[a] * y[b] : products[e] + y[a] * y[b];
    }
  }
}

// 1 - det(I - A) as the alternating sum of the principal minors of A = Y Y^T. It is at least as large as any diagonal
// entry of A, and no minor is larger than the trace: small losses keep their digits.
template <int Rows>
inline Doubles loss_by_minors(const Doubles (&products)[Rows * (Rows + 1) / 2]) {
  const Doubles aa = products[0];
  if constexpr (Rows == 1) {
    return aa;
  } else {
    const Doubles ab = products[1];
    const Doubles bb = products[Rows];
    if constexpr (Rows == 2) {
      return (aa + bb) - (aa * bb - ab * ab);
    } else {
      static_assert(Rows == 3, "the minors of up to three rows");
      const Doubles ac = products[2];
      const Doubles bc = products[4];
      const Doubles cc = products[5];
      const Doubles minor_a = bb * cc - bc * bc;
      const Doubles pairs = (aa * bb - ab * ab) + (aa * cc - ac * ac) + minor_a;
      const Doubles all = aa * minor_a - ab * (ab * cc - ac * bc) + ac * (ab * bc - ac * bb);
      return ((aa + bb) + cc) - (pairs - all);
    }
  }
}

template <int Rows>
void losses(const Tiles& tiles, const double* w, const Tile* list, std::size_t count, double* losses, double* lowest) {
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t tile = number(list[j]);
    Doubles lowest_of_tile(maxlogdet::simd::no_loss);
    for (std::size_t lane = 0; lane < tile_size; lane += double_lanes) {
      Doubles products[Rows * (Rows + 1) / 2];
      products_of_whitened<Rows>(tiles.data + tile * tiles.tile_stride + lane, tiles.entry_stride, w, products);
      const std::size_t at = tile * tile_size + lane;
      const auto remains = widened(tiles.remaining + at) > Doubles(0.0);
      const Doubles clamped = xsimd::min(xsimd::max(loss_by_minors<Rows>(products), Doubles(0.0)), Doubles(1.0));
      const Doubles loss = xsimd::select(remains, clamped, Doubles(maxlogdet::simd::no_loss));
      loss.store_unaligned(losses + at);
      lowest_of_tile = xsimd::min(lowest_of_tile, loss);
    }
    alignas(sizeof(Doubles)) double lanes[double_lanes];
    lowest_of_tile.store_aligned(lanes);
    double lowest_lane = lanes[0];
    for (const double lane : lanes) lowest_lane = lane < lowest_lane ? lane : lowest_lane;
    lowest[tile] = lowest_lane;
  }
}

}  // namespace
