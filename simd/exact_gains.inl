// SPDX-License-Identifier: MIT
// Relative gains and traces in float64, the same bits on every instruction set: additions, multiplications and
// divisions only, none fused.

namespace maxlogdet::simd {
namespace {

// Loads entries of listed candidates.
struct Listed {
  Index candidate[double_lanes];
  Doubles operator()(const float* plane) const {
    alignas(sizeof(Doubles)) double entries[double_lanes];
    for (std::size_t lane = 0; lane < double_lanes; ++lane)
      entries[lane] = static_cast<double>(plane[number(candidate[lane])]);
    return Doubles::load_aligned(entries);
  }
};

// det(I + Y Y^T) - 1, from the squared diagonal of R in a QR decomposition of [Y^T; I] by modified Gram-Schmidt: each
// entry is 1 + a sum of squares, and (1 + g) (1 + s) - 1 = g + s + g s. Nothing cancels; det = 1 + a - b^2 / c would
// lose |Y|^2 eps (1e-6 in the first rounds with a prior of 1e-5 I, where |Y|^2 is 1e10). Rows of zeros add nothing.
template <int Rows>
inline Doubles relative_gain_of_block(Doubles (&y)[Rows][dimension]) {
  Doubles tail[Rows][Rows];  // the identity below Y^T, orthogonalised along with it; tail[a][a] = 1 is implied
  Doubles relative_gain(0.0);
  for (int a = 0; a < Rows; ++a) {
    Doubles squares = y[a][0] * y[a][0];
    for (int d = 1; d < dimension; ++d) squares += y[a][d] * y[a][d];
    for (int c = 0; c < a; ++c) squares += tail[a][c] * tail[a][c];
    relative_gain = a == 0 ? squares : relative_gain + (squares + relative_gain * squares);
    const Doubles norm = Doubles(1.0) + squares;
    for (int b = a + 1; b < Rows; ++b) {
      Doubles dot = y[a][0] * y[b][0];
      for (int d = 1; d < dimension; ++d) dot += y[a][d] * y[b][d];
      for (int c = 0; c < a; ++c) dot += tail[a][c] * tail[b][c];
      const Doubles factor = dot / norm;
      for (int c = 0; c < a; ++c) tail[b][c] -= factor * tail[a][c];
      tail[b][a] = Doubles(0.0) - factor;
      for (int d = 0; d < dimension; ++d) y[b][d] -= factor * y[a][d];
    }
  }
  return relative_gain;
}

// Y = H W^T. `load(plane)` is an entry of a pack of blocks.
template <int Rows, class Load>
inline void whiten_exactly(const Planes& planes, const double* w, const Load& load, Doubles (&y)[Rows][dimension]) {
  for (int a = 0; a < Rows; ++a) {
    Doubles h[dimension];
    for (int d = 0; d < dimension; ++d)
      h[d] = load(planes.data + static_cast<std::size_t>(dimension * a + d) * planes.stride);
    for (int c = 0; c < dimension; ++c) {
      y[a][c] = Doubles(w[padded_dimension * c]) * h[0];
      for (int d = 1; d <= c; ++d) y[a][c] += Doubles(w[padded_dimension * c + d]) * h[d];
    }
  }
}

template <int Rows>
void decide(const Planes& planes, const double* w, const Index* listed, std::size_t count, double* relative_gains) {
  for (std::size_t j = 0; j < count; j += double_lanes) {
    Listed load;  // the last pack is filled with copies of the last
    for (std::size_t lane = 0; lane < double_lanes; ++lane)
      load.candidate[lane] = listed[j + lane < count ? j + lane : count - 1];
    Doubles y[Rows][dimension];
    whiten_exactly<Rows>(planes, w, load, y);
    alignas(sizeof(Doubles)) double found[double_lanes];
    relative_gain_of_block<Rows>(y).store_aligned(found);
    for (std::size_t lane = 0; lane < double_lanes && j + lane < count; ++lane) relative_gains[j + lane] = found[lane];
  }
}

// |H W^T|_F^2, a candidate's term of a linear bound of log det, for consecutive candidates.
template <int Rows>
void traces(const Planes& planes, const double* w, std::size_t count, double* values) {
  for (std::size_t i = 0; i < count; i += double_lanes) {
    Doubles y[Rows][dimension];
    whiten_exactly<Rows>(
        planes, w, [i](const float* plane) { return widened(plane + i); }, y);
    Doubles sum(0.0);
    for (int a = 0; a < Rows; ++a) {
      for (int d = 0; d < dimension; ++d) sum += y[a][d] * y[a][d];
    }
    sum.store_unaligned(values + i);
  }
}

// For rounds in which the error bound of float32 excludes too few: gains that are off by no more than a share of 1 + g.

// det(I + Y Y^T) - 1 by the pivots of I + Y Y^T, 1 + s each: (1 + g) (1 + s) - 1 = g + s + g s.
template <int Rows>
inline Doubles relative_gain_by_elimination(const Doubles (&products)[Rows * (Rows + 1) / 2]) {
  const Doubles one(1.0);
  const Doubles first = products[0];
  if constexpr (Rows == 1) {
    return first;
  } else {
    const Doubles ab = products[1];
    const Doubles inverse = one / (one + first);
    const Doubles b = ab * inverse;
    const Doubles second = products[Rows] - ab * b;
    const Doubles of_two = first + (second + first * second);
    if constexpr (Rows == 2) {
      return of_two;
    } else {
      static_assert(Rows == 3, "the pivots of up to three rows");
      const Doubles ac = products[2];
      const Doubles bc = products[4] - ac * b;
      const Doubles third = (products[5] - ac * (ac * inverse)) - bc * (bc / (one + second));
      return of_two + (third + of_two * third);
    }
  }
}

// `load(plane)` is an entry of a pack of blocks.
template <int Rows, class Load>
inline Doubles gains_in_float64(const Planes& planes, const double* w, const Load& load) {
  Doubles products[Rows * (Rows + 1) / 2];
  const auto entry = [&](std::size_t e) { return load(planes.data + e * planes.stride); };
  products_of_whitened<Rows>(entry, w, products);
  const Doubles gain = relative_gain_by_elimination<Rows>(products);
  return xsimd::select(gain > Doubles(0.0), gain, Doubles(0.0));  // NaN where a pivot has cancelled to zero
}

// Of a pack of lanes.
template <int Rows>
inline Doubles gains_in_float64(const BlocksOfLanes& blocks, const double* w, std::size_t lane) {
  if (blocks.candidate == nullptr) {
    const auto load = [lane](const float* plane) { return widened(plane + lane); };
    return gains_in_float64<Rows>(blocks.planes, w, load);
  }
  Listed load;
  std::memcpy(load.candidate, blocks.candidate + lane, sizeof load.candidate);
  return gains_in_float64<Rows>(blocks.planes, w, load);
}

template <int Rows>
Evaluated evaluate_in_float64(const Tiles& tiles, const BlocksOfLanes& blocks, const double* w, const Tile* list,
                              std::size_t count, const RoundArrays& arrays) {
  Evaluated found{-1, 0};
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t tile = number(list[j]);
    float* const gains = arrays.gains + tile * tile_size;
    for (std::size_t i = 0; i < tile_size; i += double_lanes) {
      const std::size_t lane = tile * tile_size + i;
      const auto remains = widened(tiles.remaining + lane) > Doubles(0.0);
      const Doubles evaluated = gains_in_float64<Rows>(blocks, w, lane);
      store_narrow(xsimd::select(remains, evaluated, Doubles(-1.0)), gains + i);
    }
    arrays.highest[tile] = largest(gains, tile_size);
    found.best = arrays.highest[tile] > found.best ? arrays.highest[tile] : found.best;
    found.count += tiles.in_each[tile];
  }
  return found;
}

}  // namespace
}  // namespace maxlogdet::simd
