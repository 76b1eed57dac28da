// SPDX-License-Identifier: MIT
// Relative gains in float32, with one error bound for all (simd/gain_filter.hpp). Fused and unfused units give
// different bits; the bounds of docs/numerics.md hold for both.

namespace maxlogdet::simd {
namespace {

// Y Y^T, its upper triangle by rows, with Y = H W^T, column by column of Y: a longer chain of dependent operations than
// row by row, but half of the registers. `load(e)` is entry e of a pack of blocks.
template <int Rows, class Pack, class Load, class Number>
inline void products_of_whitened(const Load& load, const Number* w, Pack (&products)[Rows * (Rows + 1) / 2]) {
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

// Factored blocks, A [ I | -[X]x ]: nine numbers instead of eighteen, and products with W through the point.

// A pack of them, A upper triangular, X = (x, y, z).
struct FactoredBlock {
  Floats a00, a01, a02, a11, a12, a22, x, y, z;
};

// A column of Y, c in 0 .. 5, for a factored block: y = A (w_t - X x w_r), row c of W being (w_t, w_r). With a
// constant c the zeros of W cost nothing.
inline void whiten_column(const FactoredBlock& b, const float* w, int c, Floats (&y)[3]) {
  const float* const row = w + padded_dimension * c;
  if (c == 0) {
    y[0] = b.a00 * Floats(row[0]);
    y[1] = y[2] = Floats(0.0F);
  } else if (c == 1) {
    y[0] = multiply_add(b.a01, Floats(row[1]), b.a00 * Floats(row[0]));
    y[1] = b.a11 * Floats(row[1]);
    y[2] = Floats(0.0F);
  } else {
    Floats z0(row[0]);
    Floats z1(row[1]);
    Floats z2(row[2]);
    if (c > 2) {
      z1 = minus_product(b.z, Floats(row[3]), z1);
      z2 = multiply_add(b.y, Floats(row[3]), z2);
    }
    if (c > 3) {
      z0 = multiply_add(b.z, Floats(row[4]), z0);
      z2 = minus_product(b.x, Floats(row[4]), z2);
    }
    if (c > 4) {
      z0 = minus_product(b.y, Floats(row[5]), z0);
      z1 = multiply_add(b.x, Floats(row[5]), z1);
    }
    y[0] = multiply_add(b.a02, z2, multiply_add(b.a01, z1, b.a00 * z0));
    y[1] = multiply_add(b.a12, z2, b.a11 * z1);
    y[2] = b.a22 * z2;
  }
}

inline void add_products(const Floats (&y)[3], int c, Floats (&products)[6]) {
  const auto add = [](const Floats& a, const Floats& b, bool is_first, Floats& sum) {
    sum = is_first ? a * b : multiply_add(a, b, sum);
  };
  add(y[0], y[0], c == 0, products[0]);
  if (c > 0) {
    add(y[0], y[1], c == 1, products[1]);
    add(y[1], y[1], c == 1, products[3]);
  }
  if (c > 1) {
    add(y[0], y[2], c == 2, products[2]);
    add(y[1], y[2], c == 2, products[4]);
    add(y[2], y[2], c == 2, products[5]);
  }
}

static_assert(tile_size % float_lanes == 0, "a tile is a number of packs");

// Y Y^T, entries (a, b), a <= b, row by row.
template <Form form, int Rows = rows_of(form)>
inline void multiply_by_transpose(const float* entries, const float* w, Floats (&products)[Rows * (Rows + 1) / 2]) {
  const auto load = [=](std::size_t e) { return Floats::load_unaligned(entries + e * tile_size); };
  if constexpr (form == factored) {
    const FactoredBlock block = {load(0), load(1), load(2), load(3), load(4), load(5), load(6), load(7), load(8)};
#pragma GCC unroll 6
    for (int c = 0; c < dimension; ++c) {
      Floats y[3];
      whiten_column(block, w, c, y);
      add_products(y, c, products);
    }
  } else {
    products_of_whitened<Rows>(load, w, products);
  }
}

// det(I + Y Y^T) - 1 as the sum of the principal minors of Y Y^T: no division, and a short chain of dependent
// operations; but if rows of Y are long and nearly parallel, minors cancel.
template <int Rows>
inline Floats relative_gain_by_minors(const Floats (&products)[Rows * (Rows + 1) / 2]) {
  const Floats aa = products[0];
  if constexpr (Rows == 1) {
    return aa;
  } else {
    const Floats ab = products[1];
    const Floats bb = products[Rows];
    if constexpr (Rows == 2) {
      return minus_product(ab, ab, multiply_add(aa, bb, aa + bb));
    } else {
      static_assert(Rows == 3, "the minors of up to three rows");
      const Floats ac = products[2];
      const Floats bc = products[4];
      const Floats cc = products[5];
      const Floats minor_a = minus_product(bc, bc, bb * cc);
      const Floats minor_b = minus_product(ac, ac, aa * cc);
      const Floats minor_c = minus_product(ab, ab, aa * bb);
      const Floats all = multiply_add(
          aa, minor_a, multiply_add(ab, minus_product(ab, cc, ac * bc), ac * minus_product(ac, bb, ab * bc)));
      return ((aa + bb) + (cc + minor_a)) + ((minor_b + minor_c) + all);
    }
  }
}

// Evaluates the listed tiles: the gains of their lanes, and the maximum of each. Returns the largest of all, and how
// many candidates these are.
template <Form form>
Evaluated evaluate_listed(const Tiles& tiles, const float* w, const Tile* list, std::size_t count,
                          const RoundArrays& arrays) {
  constexpr int rows = rows_of(form);
  Floats best(-1.0F);
  float* const gains = arrays.gains;
  float* const highest = arrays.highest;
  std::size_t evaluated = 0;
  for (std::size_t j = 0; j < count; ++j) {
    asm volatile("" ::: "memory");  // the entries of W stay in memory: in registers they would spill others
    const std::size_t tile = number(list[j]);
    Floats highest_of_tile(-1.0F);
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      Floats products[rows * (rows + 1) / 2];
      multiply_by_transpose<form>(tiles.data + tile * (entries_of(form) * tile_size) + lane, w, products);
      const std::size_t at = tile * tile_size + lane;
      const auto remains = Floats::load_unaligned(tiles.remaining + at) > Floats(0.0F);
      const Floats clamped = xsimd::max(relative_gain_by_minors<rows>(products), Floats(0.0F));  // may have cancelled
      const Floats relative_gain = xsimd::select(remains, clamped, Floats(-1.0F));
      relative_gain.store_unaligned(gains + at);
      highest_of_tile = xsimd::max(highest_of_tile, relative_gain);
    }
    highest[tile] = largest_lane(highest_of_tile);
    evaluated += tiles.in_each[tile];
    best = xsimd::max(best, highest_of_tile);
  }
  return {largest_lane(best), evaluated};
}

}  // namespace
}  // namespace maxlogdet::simd
