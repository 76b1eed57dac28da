// SPDX-License-Identifier: MIT
// Relative losses in float64, the same bits on every instruction set: additions and multiplications only, none fused.

namespace {

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
  const auto unfused = [](const Doubles& x, const Doubles& y, const Doubles& z) { return z + x * y; };
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t tile = number(list[j]);
    Doubles lowest_of_tile(maxlogdet::simd::no_loss);
    for (std::size_t lane = 0; lane < tile_size; lane += double_lanes) {
      Doubles products[Rows * (Rows + 1) / 2];
      const float* const entries = tiles.data + tile * tiles.tile_stride + lane;
      const auto load = [&](std::size_t entry) { return widened(entries + entry * tiles.entry_stride); };
      products_of_whitened<Rows>(load, w, unfused, products);
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
