// SPDX-License-Identifier: MIT
// Factored blocks, A [ I | -[X]x ]: nine numbers instead of eighteen, and products with W through the point.

namespace {

// A pack of them, A upper triangular, X = (x, y, z).
struct FactoredBlock {
  Floats a00, a01, a02, a11, a12, a22, x, y, z;
};

// Entry e at entries + offset(e).
template <class Offset>
inline FactoredBlock load_factored(const float* entries, const Offset& offset) {
  const auto at = [&](std::size_t e) { return Floats::load_unaligned(entries + offset(e)); };
  return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8)};
}

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

// Raises `largest` to the largest entry of each column of |A| [ I | |[X]x| ].
inline void take_larger_columns(const FactoredBlock& b, Floats (&largest)[dimension]) {
  const auto take = [&largest](int column, const Floats& magnitude) {
    largest[column] = xsimd::max(largest[column], magnitude);
  };
  const Floats a00 = xsimd::abs(b.a00), a01 = xsimd::abs(b.a01), a02 = xsimd::abs(b.a02);
  const Floats a11 = xsimd::abs(b.a11), a12 = xsimd::abs(b.a12), a22 = xsimd::abs(b.a22);
  const Floats x = xsimd::abs(b.x), y = xsimd::abs(b.y), z = xsimd::abs(b.z);
  const Floats last = xsimd::max(a12, a22);
  take(0, a00);
  take(1, xsimd::max(a01, a11));
  take(2, xsimd::max(a02, last));
  take(3, xsimd::max(multiply_add(a02, y, a01 * z), xsimd::max(multiply_add(a12, y, a11 * z), a22 * y)));
  take(4, xsimd::max(multiply_add(a00, z, a02 * x), last * x));
  take(5, xsimd::max(multiply_add(a01, x, a00 * y), a11 * x));
}

bool factored_max(const Planes& planes, std::size_t count, double* column_max) {
  constexpr double largest_held = 1e15;
  constexpr double room = 1 + maxlogdet::simd::sum_room;
  Floats columns[dimension];
  for (Floats& pack : columns) pack = Floats(0.0F);
  Floats farthest(0.0F);
  float last[entries_of(factored) * float_lanes];
  for (std::size_t i = 0; i < count; i += float_lanes) {
    const bool is_full = count - i >= float_lanes;
    for (std::size_t e = 0; !is_full && e < entries_of(factored); ++e) {
      const float* const plane = planes.data + plane_of(factored, e) * planes.stride;
      for (std::size_t lane = 0; lane < float_lanes; ++lane) {
        last[e * float_lanes + lane] = plane[i + lane < count ? i + lane : i];
      }
    }
    const FactoredBlock block =
        is_full ? load_factored(planes.data + i, [&](std::size_t e) { return plane_of(factored, e) * planes.stride; })
                : load_factored(last, [](std::size_t e) { return e * float_lanes; });
    take_larger_columns(block, columns);
    farthest =
        xsimd::max(farthest, xsimd::max(xsimd::abs(block.x), xsimd::max(xsimd::abs(block.y), xsimd::abs(block.z))));
  }
  double largest = static_cast<double>(largest_lane(farthest));
  for (int column = 0; column < dimension; ++column) {
    column_max[column] = room * static_cast<double>(largest_lane(columns[column]));
    if (column < 3 && !(column_max[column] <= largest)) largest = column_max[column];
  }
  return largest <= largest_held;
}

}  // namespace
