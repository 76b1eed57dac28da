// SPDX-License-Identifier: MIT
// Gains in float32, fast and with a bound of their error. Fused and unfused units give different bits; the bounds of
// docs/numerics.md hold for both.

namespace {

static_assert(tile_size % float_lanes == 0, "a tile is a number of packs");

// y = h W^T for one row of a pack of candidates: entry c is the dot product with row c of the lower triangle W.
inline void whiten(const float* entries, std::size_t stride, const float* w, Floats (&y)[dimension]) {
  Floats h[dimension];
#pragma GCC unroll 6
  for (int d = 0; d < dimension; ++d) h[d] = Floats::load_unaligned(entries + static_cast<std::size_t>(d) * stride);
#pragma GCC unroll 6
  for (int c = 0; c < dimension; ++c) y[c] = Floats(w[padded_dimension * c]) * h[0];
#pragma GCC unroll 6
  for (int d = 1; d < dimension; ++d) {
#pragma GCC unroll 6
    for (int c = d; c < dimension; ++c) y[c] = multiply_add(Floats(w[padded_dimension * c + d]), h[d], y[c]);
  }
}

inline Floats dot(const Floats (&a)[dimension], const Floats (&b)[dimension]) {
  Floats even = a[0] * b[0];
  Floats odd = a[1] * b[1];
#pragma GCC unroll 6
  for (int d = 2; d < dimension; d += 2) {
    even = multiply_add(a[d], b[d], even);
    odd = multiply_add(a[d + 1], b[d + 1], odd);
  }
  return even + odd;
}

// det(I + Y Y^T) - 1 by modified Gram-Schmidt on [Y^T; I], as decide.inl does it. Also what the error bound needs: of
// row a, orthogonalised to those before it, squares[a] + 1 is the squared length; projection[a][b] is its share of row
// b before that is orthogonalised to it, and product[a][b] their dot product.
template <int Rows>
struct Orthogonalised {
  Floats squares[Rows];
  Floats projection[Rows][Rows];
  Floats product[Rows][Rows];
  Floats growth;
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
    r.growth = a == 0 ? r.squares[a] : r.growth + multiply_add(r.growth, r.squares[a], r.squares[a]);
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

// Y Y^T, entries (a, b), a <= b, row by row.
template <Form form, int Rows = rows_of(form)>
inline void multiply_by_transpose(const float* entries, [[maybe_unused]] std::size_t stride, const float* w,
                                  Floats (&products)[Rows * (Rows + 1) / 2]) {
  if constexpr (form == factored) {
    const FactoredBlock block = load_factored(entries);
#pragma GCC unroll 6
    for (int c = 0; c < dimension; ++c) {
      Floats y[3];
      whiten_column(block, w, c, y);
      add_products(y, c, products);
    }
  } else if constexpr (Rows < 3) {
    Floats y[Rows][dimension];
    for (int a = 0; a < Rows; ++a) whiten(entries + static_cast<std::size_t>(dimension * a) * stride, stride, w, y[a]);
    for (int a = 0, e = 0; a < Rows; ++a) {
      for (int b = a; b < Rows; ++b, ++e) products[e] = dot(y[a], y[b]);
    }
  } else {  // a column of Y after the other: a longer chain of dependent operations, but it needs half of the registers
    Floats h[Rows][dimension];
    for (int a = 0; a < Rows; ++a) {
      for (int d = 0; d < dimension; ++d) {
        h[a][d] = Floats::load_unaligned(entries + static_cast<std::size_t>(dimension * a + d) * stride);
      }
    }
    for (int c = 0; c < dimension; ++c) {
      Floats y[Rows];
      for (int d = 0; d <= c; ++d) {
        const Floats weight(w[padded_dimension * c + d]);
        for (int a = 0; a < Rows; ++a) y[a] = d == 0 ? weight * h[a][0] : multiply_add(weight, h[a][d], y[a]);
      }
      for (int a = 0, e = 0; a < Rows; ++a) {
        for (int b = a; b < Rows; ++b, ++e) {
          products[e] = c == 0 ? y[a] * y[b] : multiply_add(y[a], y[b], products[e]);
        }
      }
    }
  }
}

// det(I + Y Y^T) - 1 as the sum of the principal minors of Y Y^T: no division, and a short chain of dependent
// operations; but where the rows of Y are long and nearly parallel, minors cancel.
template <int Rows>
inline Floats growth_by_minors(const Floats (&products)[Rows * (Rows + 1) / 2]) {
  const Floats aa = products[0];
  if constexpr (Rows == 1) {
    return aa;
  } else {
    const Floats ab = products[1];
    const Floats bb = products[Rows];
    if constexpr (Rows == 2) {
      return minus_product(ab, ab, multiply_add(aa, bb, aa + bb));
    } else {
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

template <Form form>
float screen(const Tiles& tiles, const float* w, const std::uint32_t* list, std::size_t count, float* growths,
             float* highest) {
  constexpr int rows = rows_of(form);
  Floats best(-1.0F);
  for (std::size_t j = 0; j < count; ++j) {
    asm volatile("" ::: "memory");  // the entries of W stay in memory: they would crowd others out of the registers
    const std::size_t tile = list[j];
    Floats most(-1.0F);
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      Floats products[rows * (rows + 1) / 2];
      multiply_by_transpose<form>(tiles.data + tile * tiles.tile_stride + lane, tiles.entry_stride, w, products);
      const std::size_t at = tile * tile_size + lane;
      const auto remains = Floats::load_unaligned(tiles.remaining + at) > Floats(0.0F);
      const Floats clamped = xsimd::max(growth_by_minors<rows>(products), Floats(0.0F));  // may have cancelled
      const Floats growth = xsimd::select(remains, clamped, Floats(-1.0F));
      growth.store_unaligned(growths + at);
      most = xsimd::max(most, growth);
    }
    highest[tile] = largest_lane(most);
    best = xsimd::max(best, most);
  }
  return largest_lane(best);
}

// | |W| |h| |^2 of a row: what rounding moves a row of Y by is in proportion to its root. `w`: |W|.
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

// Y = H W^T, and the squares of what its rows can be off by.
template <Form form, int Rows = rows_of(form)>
inline void whiten_with_errors(const float* entries, [[maybe_unused]] std::size_t stride, const float* w,
                               const float* absolute_w, const float (&row_errors)[3], Floats (&y)[Rows][dimension],
                               Floats (&delta)[Rows]) {
  // Below it these products can underflow, to zero if the caller has asked for that.
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

// The square of how much the volume sqrt(det) can be off when row a of Y is off by up to delta[a], given their squares.
// The volume is linear in each row, so it is the sum over rows of delta times (the volume that the other rows span +
// mixed terms); here by (x + y + z)^2 <= 3 (x^2 + y^2 + z^2) and, mixed terms being small, (x + y)^2 <= 1.1 x^2 + 11
// y^2.
template <int Rows>
inline Floats volume_error_squared(const Orthogonalised<Rows>& r, const Floats (&delta)[Rows]) {
  const Floats most(1.1F);
  const Floats mixed(11.0F);
  if constexpr (Rows == 1) {
    return delta[0];
  } else {
    const Floats one(1.0F);
    const Floats a = one + r.squares[0];       // |a|^2
    const Floats b_left = one + r.squares[1];  // |b|^2 without its share of a
    const Floats b = multiply_add(r.projection[0][1], r.product[0][1], b_left);
    if constexpr (Rows == 2) {
      return Floats(2.0F) * (delta[0] * (most * b + mixed * delta[1]) + delta[1] * a);
    } else {
      const Floats s = r.projection[0][1];
      const Floats t = r.projection[0][2];
      const Floats c_last = one + r.squares[2];                                         // without those of a and b
      const Floats c_left = multiply_add(r.projection[1][2], r.product[1][2], c_last);  // without that of a
      const Floats c = multiply_add(t, r.product[0][2], c_left);
      // b ^ c with b = s a + b', c = t a + c':  a ^ (s c' - t b') + b' ^ c', two that are orthogonal
      const Floats bc = Floats(2.0F) * a * (s * s * c_left + t * t * b_left) + b_left * c_last;
      const Floats bc_mixed = Floats(3.0F) * (delta[1] * c + delta[2] * (b + delta[1]));
      return Floats(3.0F) * (delta[0] * (most * bc + mixed * bc_mixed) +
                             delta[1] * a * (most * c_left + mixed * delta[2]) + delta[2] * a * b_left);
    }
  }
}

template <Form form>
float screen_with_care(const Tiles& tiles, const float* w, const std::uint32_t* list, std::size_t count, float* growths,
                       float* highest, float* lower) {
  constexpr int rows = rows_of(form);
  // Of a row of Y relative to | |W| |h| |, by the time that it is orthogonal to those before it; of the growth.
  constexpr float unit = 0x1p-24F;
  constexpr float of_rows[] = {8 * unit, 22 * unit, 38 * unit};
  constexpr float of_factored_rows[] = {12 * unit, 26 * unit, 42 * unit};
  constexpr float growth_error = 12 * rows * unit;
  const Floats tiny(1e-36F);
  const Floats huge(1e36F);  // above it these products may have overflowed
  const Floats nothing(-1.0F);
  constexpr auto smallest = static_cast<float>(maxlogdet::simd::smallest_entry);
  float absolute_w[dimension * padded_dimension];
  for (int i = 0; i < dimension * padded_dimension; ++i) {
    const float magnitude = w[i] < 0 ? -w[i] : w[i];
    absolute_w[i] = magnitude > smallest ? magnitude : smallest;
  }
  Floats best_assured = nothing;
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t tile = list[j];
    Floats most = nothing;
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      Floats y[rows][dimension];
      Floats delta[rows];
      whiten_with_errors<form>(tiles.data + tile * tiles.tile_stride + lane, tiles.entry_stride, w, absolute_w,
                               form == factored ? of_factored_rows : of_rows, y, delta);
      const Orthogonalised<rows> r = orthogonalise<rows>(y);
      const Floats volume = square_root(Floats(1.0F) + r.growth);
      const Floats error = square_root(volume_error_squared<rows>(r, delta));
      const Floats both = multiply_add(Floats(growth_error), r.growth, Floats(2.0F) * error * volume) + tiny;
      const Floats above = r.growth + both + error * error;
      const Floats below = r.growth - both - error * error;

      const std::size_t at = tile * tile_size + lane;
      const auto remains = Floats::load_unaligned(tiles.remaining + at) > Floats(0.0F);
      const auto is_sound = above < huge;  // false for NaN too
      const Floats infinity(std::numeric_limits<float>::infinity());
      const Floats upper = xsimd::select(remains, xsimd::select(is_sound, above, infinity), nothing);
      const Floats assured = xsimd::select(remains, xsimd::select(is_sound, below, nothing), nothing);
      upper.store_unaligned(growths + at);
      assured.store_unaligned(lower + at);
      most = xsimd::max(most, upper);
      best_assured = xsimd::max(best_assured, assured);
    }
    highest[tile] = largest_lane(most);
  }
  return largest_lane(best_assured);
}

// Of every four floats of four packs: rows become columns. Between planes or tiles, with an entry a row, and records,
// with a candidate a row.
inline void transpose(Floats (&m)[4]) {
  const Floats ac_low = zip_low(m[0], m[2]);
  const Floats ac_high = zip_high(m[0], m[2]);
  const Floats bd_low = zip_low(m[1], m[3]);
  const Floats bd_high = zip_high(m[1], m[3]);
  m[0] = zip_low(ac_low, bd_low);
  m[1] = zip_high(ac_low, bd_low);
  m[2] = zip_low(ac_high, bd_high);
  m[3] = zip_high(ac_high, bd_high);
}

template <Form form>
void make_records(const Planes& planes, std::size_t count, float* records) {
  constexpr std::size_t size = maxlogdet::simd::record_size(form);
  constexpr std::size_t entries = entries_of(form);
  for (std::size_t i = 0; i < count; i += float_lanes, records += float_lanes * size) {
    float* to[float_lanes];
    for (std::size_t lane = 0; lane < float_lanes; ++lane) to[lane] = records + lane * size;
    for (std::size_t e = 0; e < size; e += 4) {
      Floats m[4];
      for (std::size_t j = 0; j < 4; ++j) {  // beyond the last entry: filling
        m[j] = Floats::load_unaligned(planes.data + plane_of(form, e + j < entries ? e + j : 0) * planes.stride + i);
      }
      transpose(m);
      for (std::size_t j = 0; j < 4; ++j) store_parts(m[j], to + j, e);
    }
  }
}

template <Form form>
void gather(const float* records, const std::uint32_t* indices, std::size_t count, float* tiles) {
  constexpr std::size_t size = maxlogdet::simd::record_size(form);
  constexpr std::size_t entries = entries_of(form);
  for (std::size_t j = 0; j < count; j += tile_size, tiles += entries * tile_size) {
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      const float* from[float_lanes];
      for (std::size_t l = 0; l < float_lanes; ++l) from[l] = records + indices[j + lane + l] * size;
      for (std::size_t e = 0; e < size; e += 4) {
        Floats m[4];
        for (std::size_t d = 0; d < 4; ++d) m[d] = load_parts(from + d, e);
        transpose(m);
        for (std::size_t d = 0; d < 4 && e + d < entries; ++d) m[d].store_unaligned(tiles + (e + d) * tile_size + lane);
      }
    }
  }
}

template <Form form>
void column_max(const float* tiles, std::size_t tile_count, double* largest) {
  Floats most[dimension];
  for (Floats& pack : most) pack = Floats(0.0F);
  for (std::size_t tile = 0; tile < tile_count; ++tile, tiles += entries_of(form) * tile_size) {
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      if constexpr (form == factored) {
        take_larger_columns(load_factored(tiles + lane), most);
      } else {
        for (std::size_t e = 0; e < entries_of(form); ++e) {
          Floats& pack = most[e % dimension];
          pack = xsimd::max(pack, xsimd::abs(Floats::load_unaligned(tiles + e * tile_size + lane)));
        }
      }
    }
  }
  constexpr double room = form == factored ? 1 + 1e-6 : 1;  // for the roundings above
  for (int column = 0; column < dimension; ++column) {
    largest[column] = room * static_cast<double>(largest_lane(most[column]));
  }
}

std::size_t list_between(const float* values, std::size_t count, std::size_t part, std::size_t parts, float least,
                         float most, std::uint32_t* list) {
  std::size_t found = 0;
  for (std::size_t first = tile_size * part; first < count; first += tile_size * parts) {
    for (std::size_t i = first; i < first + tile_size; i += float_lanes) {
      const Floats value = Floats::load_unaligned(values + i);
      found +=
          list_lanes((value >= Floats(least)) & (value <= Floats(most)), static_cast<std::uint32_t>(i), list + found);
    }
  }
  while (found > 0 && list[found - 1] >= count) --found;  // beyond the end of values
  return found;
}

template <Form form>
ScreenedTiles screen_between(const Tiles& tiles, const float* w, const float* bounds, std::size_t tile_count,
                             std::size_t part, std::size_t parts, float least, float most, std::uint32_t* list,
                             float* growths, float* highest) {
  const std::size_t count = list_between(bounds, tile_count, part, parts, least, most, list);
  return {count, screen<form>(tiles, w, list, count, growths, highest)};
}

template <Form form>
std::size_t list_survivors(const Tiles& tiles, const float* growths, const float* highest, float threshold,
                           const std::uint32_t* list, std::size_t count, const float* unlike, std::uint32_t* lanes) {
  std::size_t found = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const std::uint32_t tile = list[j];
    if (highest[tile] < threshold) continue;
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      const std::size_t at = tile * tile_size + lane;
      auto survives = Floats::load_unaligned(growths + at) >= Floats(threshold);
      if (unlike != nullptr) {
        const float* entries = tiles.data + tile * tiles.tile_stride + lane;
        auto is_same = survives;
        for (std::size_t e = 0; e < entries_of(form); ++e, entries += tiles.entry_stride) {
          is_same = is_same & (Floats::load_unaligned(entries) == Floats(unlike[e]));
        }
        survives = survives & !is_same;
      }
      found += list_lanes(survives, static_cast<std::uint32_t>(at), lanes + found);
    }
  }
  return found;
}

float largest(const float* values, std::size_t count) {
  alignas(sizeof(Floats)) static constexpr float numbers[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const Floats lane = Floats::load_aligned(numbers);
  const Floats nothing(-1.0F);
  Floats most = nothing;
  std::size_t i = 0;
  for (; i + float_lanes <= count; i += float_lanes) most = xsimd::max(most, Floats::load_unaligned(values + i));
  if (i < count) {
    const auto is_one = lane < Floats(static_cast<float>(count - i));
    most = xsimd::max(most, xsimd::select(is_one, Floats::load_unaligned(values + i), nothing));
  }
  return largest_lane(most);
}

// The float just below one that is no zero.
inline float next_below(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  bits = value > 0 ? bits - 1 : bits + 1;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

inline float rounded_down(double value) {
  return static_cast<float>(value - (value < 0 ? -value : value) * maxlogdet::simd::bound_room);
}
inline float rounded_up(double value) {
  return static_cast<float>(value + (value < 0 ? -value : value) * maxlogdet::simd::bound_room);
}

// The proofs are in docs/numerics.md.
template <Form form>
void screen_promising(const Tiles& tiles, const float* w, PromisingRound& round) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto screen_down_to = [&](float least, float below) {
    std::uint32_t* const list = round.list + round.listed;
    const std::size_t count = list_between(round.bounds, round.tile_count, 0, 1, least, below, list);
    round.lowest_listed = least;
    round.listed += count;
    const float best = screen<form>(tiles, w, list, count, round.growths, round.highest);
    round.best = best > round.best ? best : round.best;
    const auto growth = static_cast<double>(round.best);
    round.assured = growth - ((round.slope - 1) * growth + round.offset);
    return growth > round.nearest && growth < round.farthest;
  };
  if (!screen_down_to(round.clearly, infinity)) return;
  const double stale = round.assured > 0 ? round.assured - (1 + round.assured) * round.drift : 0;
  const float threshold = stale > 0 ? rounded_down(stale) : maxlogdet::simd::any_candidate;
  if (threshold < round.clearly && !screen_down_to(threshold, next_below(round.clearly))) return;
  round.is_done = true;

  const double least = (round.assured - round.offset) * (round.slope < 2 ? 2 - round.slope : 0);  // 1 / slope is more
  const float least_growth = least > 0 ? rounded_down(least) : maxlogdet::simd::any_candidate;
  std::size_t holders = 0;  // of survivors; most often it is one tile
  std::uint32_t holder = 0;
  for (std::size_t j = 0; j < round.listed; ++j) {
    const std::uint32_t tile = round.list[j];
    const bool holds = round.highest[tile] >= least_growth;
    holder = holds ? tile : holder;
    holders += holds ? 1 : 0;
  }
  const bool is_one = holders == 1;
  round.survivors =
      list_survivors<form>(tiles, round.growths, round.highest, least_growth, is_one ? &holder : round.list,
                           is_one ? 1 : round.listed, nullptr, round.lanes);
  const float slope = rounded_up(round.slope * (1 + 1e-6));
  const float offset = rounded_up(round.offset);
  for (std::size_t j = 0; j < round.listed; ++j) {
    const std::uint32_t tile = round.list[j];
    round.bounds[tile] = round.highest[tile] < 0 ? -1.0F : slope * round.highest[tile] + offset;
  }
  round.highest_bound = largest(round.bounds, round.tile_count);
}

}  // namespace
