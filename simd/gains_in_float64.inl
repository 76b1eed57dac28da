// SPDX-License-Identifier: MIT
// Relative gains in float64, off by no more than a share of 1 + g: for rounds in which the error bound of float32
// excludes too few.

namespace {

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

// By elimination, or as those that decide, which take twice as long and lose fewer digits.
template <int Rows, class Load>
inline Doubles gains_in_float64(const Planes& planes, const double* w, bool by_elimination, const Load& load) {
  if (!by_elimination) {
    Doubles y[Rows][dimension];
    whiten_exactly<Rows>(planes, w, load, y);
    return relative_gain_of_block<Rows>(y);
  }
  Doubles products[Rows * (Rows + 1) / 2];
  const auto entry = [&](std::size_t e) { return load(planes.data + e * planes.stride); };
  const auto fused = [](const Doubles& x, const Doubles& y, const Doubles& z) { return multiply_add(x, y, z); };
  products_of_whitened<Rows>(entry, w, fused, products);
  return xsimd::max(relative_gain_by_elimination<Rows>(products), Doubles(0.0));
}

// Of a pack of lanes.
template <int Rows>
inline Doubles gains_in_float64(const BlocksOfLanes& blocks, const double* w, bool by_elimination, std::size_t lane) {
  if (blocks.candidate == nullptr) {
    const auto load = [lane](const float* plane) { return widened(plane + lane); };
    return gains_in_float64<Rows>(blocks.planes, w, by_elimination, load);
  }
  Listed load;
  std::memcpy(load.candidate, blocks.candidate + lane, sizeof load.candidate);
  return gains_in_float64<Rows>(blocks.planes, w, by_elimination, load);
}

template <int Rows>
Evaluated evaluate_in_float64(const Tiles& tiles, const BlocksOfLanes& blocks, const double* w, bool by_elimination,
                              const Tile* list, std::size_t count, const RoundArrays& arrays) {
  Evaluated found{-1, 0};
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t tile = number(list[j]);
    float* const gains = arrays.gains + tile * tile_size;
    for (std::size_t i = 0; i < tile_size; i += double_lanes) {
      const std::size_t lane = tile * tile_size + i;
      const auto remains = widened(tiles.remaining + lane) > Doubles(0.0);
      const Doubles evaluated = gains_in_float64<Rows>(blocks, w, by_elimination, lane);
      store_narrow(xsimd::select(remains, evaluated, Doubles(-1.0)), gains + i);
    }
    arrays.highest[tile] = largest(gains, tile_size);
    found.best = arrays.highest[tile] > found.best ? arrays.highest[tile] : found.best;
    found.count += tiles.in_each[tile];
  }
  return found;
}

}  // namespace
