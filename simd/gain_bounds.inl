// SPDX-License-Identifier: MIT
// Relative gains in float32, each candidate with a bound of its own error, for rounds in which one bound for all
// excludes none.

namespace {

// det(I + Y Y^T) - 1 by modified Gram-Schmidt on [Y^T; I], as in exact_gains.inl, and the terms of its error bound: of
// row a, orthogonalised to those before it, squares[a] + 1 is the squared length; projection[a][b] is its coefficient
// in row b before that is orthogonalised to it, and product[a][b] their dot product.
template <int Rows>
struct Orthogonalised {
  Floats squares[Rows];
  Floats projection[Rows][Rows];
  Floats product[Rows][Rows];
  Floats relative_gain;
};

template <int Rows>
inline Orthogonalised<Rows> orthogonalise(Floats (&y)[Rows][dimension]) {
  Orthogonalised<Rows> r;
  Floats tail[Rows][Rows];  // the identity below Y^T
#pragma GCC unroll 6
  for (int a = 0; a < Rows; ++a) {
    r.squares[a] = dot(y[a], y[a]);
#pragma GCC unroll 6
    for (int c = 0; c < a; ++c) r.squares[a] = multiply_add(tail[a][c], tail[a][c], r.squares[a]);
    r.relative_gain =
        a == 0 ? r.squares[a] : r.relative_gain + multiply_add(r.relative_gain, r.squares[a], r.squares[a]);
    const Floats inverse_norm = quotient(Floats(1.0F), Floats(1.0F) + r.squares[a]);
#pragma GCC unroll 6
    for (int b = a + 1; b < Rows; ++b) {
      Floats product = dot(y[a], y[b]);
#pragma GCC unroll 6
      for (int c = 0; c < a; ++c) product = multiply_add(tail[a][c], tail[b][c], product);
      const Floats projection = product * inverse_norm;
      r.product[a][b] = product;
      r.projection[a][b] = projection;
      const Floats minus = Floats(0.0F) - projection;
#pragma GCC unroll 6
      for (int c = 0; c < a; ++c) tail[b][c] = multiply_add(minus, tail[a][c], tail[b][c]);
      tail[b][a] = minus;
#pragma GCC unroll 6
      for (int d = 0; d < dimension; ++d) y[b][d] = multiply_add(minus, y[a][d], y[b][d]);
    }
  }
  return r;
}

// | |W| |h| |^2 of a row: rounding errors of that row of Y are proportional to its root. `w`: |W|.
inline Floats rounding_squares(const float* entries, std::size_t stride, const float* w) {
  Floats h[dimension];
#pragma GCC unroll 6
  for (int d = 0; d < dimension; ++d) {
    h[d] = xsimd::abs(Floats::load_unaligned(entries + static_cast<std::size_t>(d) * stride));
  }
  Floats squares(0.0F);
#pragma GCC unroll 6
  for (int c = 0; c < dimension; ++c) {
    Floats sum = Floats(w[padded_dimension * c]) * h[0];
#pragma GCC unroll 6
    for (int d = 1; d <= c; ++d) sum = multiply_add(Floats(w[padded_dimension * c + d]), h[d], sum);
    squares = multiply_add(sum, sum, squares);
  }
  return squares;
}

// Y = H W^T, and the squares of its rows' error bounds.
template <Form form, int Rows = rows_of(form)>
inline void whiten_with_errors(const float* entries, [[maybe_unused]] std::size_t stride, const float* w,
                               const float* absolute_w, const float (&row_errors)[3], Floats (&y)[Rows][dimension],
                               Floats (&delta)[Rows]) {
  // Products below it may underflow, and denormal ones be flushed to zero.
  const Floats smallest_normal(std::numeric_limits<float>::min());
  Floats squares[Rows];
  if constexpr (form == factored) {
    const FactoredBlock block = load_factored(entries);
#pragma GCC unroll 6
    for (int c = 0; c < dimension; ++c) {
      Floats column[3];
      whiten_column(block, w, c, column);
      for (int a = 0; a < 3; ++a) y[a][c] = column[a];
    }
    rounding_squares(block, absolute_w, squares);
  } else {
#pragma GCC unroll 3
    for (int a = 0; a < Rows; ++a) {
      const float* const row = entries + static_cast<std::size_t>(dimension * a) * stride;
      whiten(row, stride, w, y[a]);
      squares[a] = rounding_squares(row, stride, absolute_w);
    }
  }
#pragma GCC unroll 3
  for (int a = 0; a < Rows; ++a) {
    delta[a] = xsimd::max(Floats(row_errors[a] * row_errors[a]) * squares[a], smallest_normal);
  }
}

// The square of an error bound of the volume sqrt(det), row a of Y being off by up to sqrt(delta[a]). The volume is
// linear in each row, so the error is the sum over rows of their error times (the volume that the other rows span +
// mixed terms); here by (x + y + z)^2 <= 3 (x^2 + y^2 + z^2) and, mixed terms being small, (x + y)^2 <= 1.1 x^2 + 11
// y^2.
template <int Rows>
inline Floats volume_error_squared(const Orthogonalised<Rows>& r, const Floats (&delta)[Rows]) {
  const Floats first(1.1F);
  const Floats mixed(11.0F);
  if constexpr (Rows == 1) {
    return delta[0];
  } else {
    const Floats one(1.0F);
    const Floats a = one + r.squares[0];       // |a|^2
    const Floats b_left = one + r.squares[1];  // |b|^2 without its part along a
    const Floats b = multiply_add(r.projection[0][1], r.product[0][1], b_left);
    if constexpr (Rows == 2) {
      return Floats(2.0F) * (delta[0] * (first * b + mixed * delta[1]) + delta[1] * a);
    } else {
      static_assert(Rows == 3, "the volumes of up to three rows");
      const Floats s = r.projection[0][1];
      const Floats t = r.projection[0][2];
      const Floats c_last = one + r.squares[2];  // without its parts along a and b
      const Floats c_left = multiply_add(r.projection[1][2], r.product[1][2], c_last);  // without its part along a
      const Floats c = multiply_add(t, r.product[0][2], c_left);
      // b ^ c with b = s a + b', c = t a + c':  a ^ (s c' - t b') + b' ^ c', two that are orthogonal
      const Floats bc = Floats(2.0F) * a * (s * s * c_left + t * t * b_left) + b_left * c_last;
      const Floats bc_mixed = Floats(3.0F) * (delta[1] * c + delta[2] * (b + delta[1]));
      return Floats(3.0F) * (delta[0] * (first * bc + mixed * bc_mixed) +
                             delta[1] * a * (first * c_left + mixed * delta[2]) + delta[2] * a * b_left);
    }
  }
}

// Bounds of the exact relative gains of a pack; NaN or infinite where float32 has overflowed.
struct GainBounds {
  Floats lower, upper;
};

template <Form form>
[[gnu::always_inline]] inline GainBounds gain_bounds(const float* entries, std::size_t stride, const float* w,
                                                     const float* absolute_w) {
  constexpr int rows = rows_of(form);
  // Rounding errors of a row of Y, relative to | |W| |h| |, once it is orthogonal to those before it; and of the
  // relative gain.
  constexpr auto unit = static_cast<float>(maxlogdet::simd::float_unit_roundoff);
  constexpr float row_errors[] = {8 * unit, 22 * unit, 38 * unit};
  constexpr float factored_row_errors[] = {12 * unit, 26 * unit, 42 * unit};
  constexpr float relative_gain_error = 12 * rows * unit;
  const Floats tiny(1e-36F);
  Floats y[rows][dimension];
  Floats delta[rows];
  whiten_with_errors<form>(entries, stride, w, absolute_w, form == factored ? factored_row_errors : row_errors, y,
                           delta);
  const Orthogonalised<rows> r = orthogonalise<rows>(y);
  const Floats volume = square_root(Floats(1.0F) + r.relative_gain);
  const Floats error = square_root(volume_error_squared<rows>(r, delta));
  const Floats both = multiply_add(Floats(relative_gain_error), r.relative_gain, Floats(2.0F) * error * volume) + tiny;
  return {r.relative_gain - both - error * error, r.relative_gain + both + error * error};
}

// |W|, its entries at least smallest_entry.
inline void magnitudes_of(const float* w, float (&magnitudes)[dimension * padded_dimension]) {
  constexpr auto smallest = static_cast<float>(maxlogdet::simd::smallest_entry);
  for (int i = 0; i < dimension * padded_dimension; ++i) {
    const float magnitude = w[i] < 0 ? -w[i] : w[i];
    magnitudes[i] = magnitude > smallest ? magnitude : smallest;
  }
}

// As evaluate_listed; returns the maximum lower bound.
template <Form form>
inline Evaluated evaluate_listed_with_care(const Tiles& tiles, const float* w, const Tile* list, std::size_t count,
                                           const RoundArrays& arrays) {
  const Floats huge(1e36F);  // above it products may have overflowed
  const Floats infinity(std::numeric_limits<float>::infinity());
  const Floats nothing(-1.0F);
  float absolute_w[dimension * padded_dimension];
  magnitudes_of(w, absolute_w);
  Floats best_assured = nothing;
  float* const gains = arrays.gains;
  float* const lower = arrays.lower;
  float* const highest = arrays.highest;
  std::size_t evaluated = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t tile = number(list[j]);
    Floats highest_of_tile = nothing;
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      const GainBounds bounds =
          gain_bounds<form>(tiles.data + tile * tiles.tile_stride + lane, tiles.entry_stride, w, absolute_w);
      const std::size_t at = tile * tile_size + lane;
      const auto remains = Floats::load_unaligned(tiles.remaining + at) > Floats(0.0F);
      const auto is_sound = bounds.upper < huge;  // false for NaN too
      const Floats upper = xsimd::select(remains, xsimd::select(is_sound, bounds.upper, infinity), nothing);
      const Floats assured = xsimd::select(remains, xsimd::select(is_sound, bounds.lower, nothing), nothing);
      upper.store_unaligned(gains + at);
      assured.store_unaligned(lower + at);
      highest_of_tile = xsimd::max(highest_of_tile, upper);
      best_assured = xsimd::max(best_assured, assured);
    }
    highest[tile] = largest_lane(highest_of_tile);
    evaluated += tiles.in_each[tile];
  }
  return {largest_lane(best_assured), evaluated};
}

}  // namespace
