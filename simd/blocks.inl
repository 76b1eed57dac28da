// SPDX-License-Identifier: MIT
// The part of the kernel body that makes blocks from points, one match a lane; included by simd/kernel.inl, whose
// rules hold here too. Arithmetic is float64, rounded to float32 when stored, by + - * / and sqrt in one fixed order:
// the same bits on every instruction set.
//
// Weighting and third row are template parameters. Whether an optional array is there is asked in the loop: that branch
// always goes the same way, and costs nothing next to sixteen times the code.

namespace {

using maxlogdet::simd::BlockInput;
using maxlogdet::simd::BlockOutput;
using maxlogdet::simd::BlockWeighting;
using maxlogdet::simd::ThirdRow;
using Mask = xsimd::batch_bool<double>;
// What float64 of a pack is rounded to; xsimd has no float32 batch of as many double_lanes.
typedef float Narrow __attribute__((vector_size(double_lanes * sizeof(float))));  // NOLINT(modernize-use-using)

constexpr double largest_double = 1.7976931348623157e308;
constexpr double singular_ray_cosine = 1e-6;  // below it H_p^n has lost more digits than float32 has

inline Doubles negated(const Doubles& value) { return Doubles(-0.0) - value; }
inline Mask is_finite(const Doubles& value) { return xsimd::abs(value) <= Doubles(largest_double); }
inline Mask is_positive(const Doubles& value) { return (value > Doubles(0.0)) & (value <= Doubles(largest_double)); }

// The input of some consecutive matches, an array per value, so that packs load whole vectors. Well before they do: a
// vector load right after the scalar stores it reads from would stall. Up to a whole pack the last match is repeated,
// which no maximum notices.
constexpr std::size_t tile_matches = 64;
static_assert(tile_matches % double_lanes == 0, "a tile holds whole packs");

struct Tile {
  alignas(64) double point[3][tile_matches];
  alignas(64) double sigma[tile_matches];
  alignas(64) double weight[tile_matches];
  alignas(64) double has_third[tile_matches];
  alignas(64) double usable[tile_matches];
  alignas(64) double map_covariance[9][tile_matches];
};

inline Doubles load(const double (&values)[tile_matches], std::size_t i) { return Doubles::load_aligned(values + i); }

inline void repeat_last(double (&values)[tile_matches], std::size_t count) {
  for (std::size_t i = count; i % double_lanes != 0; ++i) values[i] = values[count - 1];
}

inline void fill(double (&values)[tile_matches], const double* source, std::size_t count) {
  if (source == nullptr) return;
  for (std::size_t i = 0; i < count; ++i) values[i] = source[i];
  repeat_last(values, count);
}

inline void fill(double (&values)[tile_matches], const unsigned char* source, std::size_t count) {
  if (source == nullptr) return;
  for (std::size_t i = 0; i < count; ++i) values[i] = source[i] != 0 ? 1.0 : 0.0;
  repeat_last(values, count);
}

template <class T>
inline const T* from(const T* array, std::size_t first) {
  return array == nullptr ? nullptr : array + first;
}

template <BlockWeighting weighting, ThirdRow third>
inline void fill(Tile& tile, const BlockInput& input, std::size_t first, std::size_t count) {
  const double* const points = input.points + 3 * first;
  for (std::size_t i = 0; i < count; ++i) {
    tile.point[0][i] = points[3 * i];
    tile.point[1][i] = points[3 * i + 1];
    tile.point[2][i] = points[3 * i + 2];
  }
  for (auto& coordinate : tile.point) repeat_last(coordinate, count);
  fill(tile.sigma, from(input.sigmas, first), count);
  fill(tile.weight, from(input.weights, first), count);
  fill(tile.usable, from(input.usable, first), count);
  if (third != ThirdRow::none) fill(tile.has_third, from(input.has_third, first), count);
  if (weighting == BlockWeighting::measurement_and_map && input.map_covariances != nullptr) {
    const double* const covariances = input.map_covariances + 9 * first;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t entry = 0; entry < 9; ++entry) tile.map_covariance[entry][i] = covariances[9 * i + entry];
    }
    for (auto& entry : tile.map_covariance) repeat_last(entry, count);
  }
}

struct Point {
  Doubles x, y, z;
};

inline Point transform(const double* T_cw, const Tile& tile, std::size_t i) {
  const Doubles x = load(tile.point[0], i);
  const Doubles y = load(tile.point[1], i);
  const Doubles z = load(tile.point[2], i);
  Doubles p[3];
  for (int row = 0; row < 3; ++row) {
    const double* const r = T_cw + 4 * row;
    p[row] = Doubles(r[0]) * x + Doubles(r[1]) * y + Doubles(r[2]) * z + Doubles(r[3]);
  }
  return {p[0], p[1], p[2]};
}

// J = d z / d p_c.
template <ThirdRow third, int Rows>
inline void projection_jacobian(const BlockInput& input, const Point& p, Doubles (&j)[Rows][3]) {
  const Doubles zero(0.0);
  const Doubles inverse_z = Doubles(1.0) / p.z;
  const Doubles x = p.x * inverse_z;
  const Doubles y = p.y * inverse_z;
  const Doubles fx = Doubles(input.fx) * inverse_z;
  const Doubles fy = Doubles(input.fy) * inverse_z;
  j[0][0] = fx;
  j[0][1] = zero;
  j[0][2] = negated(fx) * x;
  j[1][0] = zero;
  j[1][1] = fy;
  j[1][2] = negated(fy) * y;
  if constexpr (third == ThirdRow::stereo) {  // u_right = u - bf / Z
    j[2][0] = fx;
    j[2][1] = zero;
    j[2][2] = j[0][2] + Doubles(input.bf) * inverse_z * inverse_z;
  } else if constexpr (third == ThirdRow::depth) {
    j[2][0] = zero;
    j[2][1] = zero;
    j[2][2] = Doubles(1.0);
  }
}

// h = factor [ I | -[p]x ].
template <int Rows>
inline void times_point_jacobian(const Doubles (&factor)[Rows][3], const Point& p, Doubles (&h)[Rows][dimension]) {
  for (int row = 0; row < Rows; ++row) {
    const Doubles a = factor[row][0];
    const Doubles b = factor[row][1];
    const Doubles c = factor[row][2];
    h[row][0] = a;
    h[row][1] = b;
    h[row][2] = c;
    h[row][3] = c * p.y - b * p.z;
    h[row][4] = a * p.z - c * p.x;
    h[row][5] = b * p.x - a * p.y;
  }
}

// H_c in the camera frame: H_p^n^-1 = [J; 0 0 1]^-1, and the row of zeros that the paper appends to H_x leaves
// [1 0 -X/Z; 0 1 -Y/Z; 0 0 0] of it. fx and fy cancel. With a third measurement J^-1 J = I is left.
template <ThirdRow third, int Rows>
inline void map_bias_block(const Point& p, const Mask& has_third, Doubles (&h)[Rows][dimension]) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  Doubles x = negated(p.x / p.z);
  Doubles y = negated(p.y / p.z);
  if constexpr (third == ThirdRow::none) {
    times_point_jacobian({{one, zero, x}, {zero, one, y}}, p, h);
  } else {
    x = xsimd::select(has_third, zero, x);
    y = xsimd::select(has_third, zero, y);
    times_point_jacobian({{one, zero, x}, {zero, one, y}, {zero, zero, one}}, p, h);
  }
}

// H_c in the world frame. H_c = B [I | -[p]x] where the columns of B solve [J R; e_3^T] B = [J; 0]: J (R B - I) = 0, so
// R B = I - p g^T, since p spans the null space of J; and e_3^T B = 0 gives g = R e_3 / (e_3^T R^T p), the world's z
// axis seen from the camera over the ray's share of it. So B = R^T (I - p g^T); singular where that share is zero.
// Returns where it is. With a third measurement g = 0.
template <ThirdRow third>
inline Mask map_bias_world_block(const double* T_cw, const Point& p, const Mask& has_third,
                                 Doubles (&h)[3][dimension]) {
  const Doubles zero(0.0);
  Doubles r[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r[i][j] = Doubles(T_cw[4 * i + j]);
  }
  const Doubles share = r[0][2] * p.x + r[1][2] * p.y + r[2][2] * p.z;
  const Doubles norm = xsimd::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  Mask is_singular = xsimd::abs(share) < Doubles(singular_ray_cosine) * norm;
  Doubles g[3] = {r[0][2] / share, r[1][2] / share, r[2][2] / share};
  if constexpr (third != ThirdRow::none) {
    is_singular = is_singular & !has_third;
    for (Doubles& entry : g) entry = xsimd::select(has_third, zero, entry);
  }
  Doubles b[3][3];
  for (int i = 0; i < 3; ++i) {
    const Doubles projected = r[0][i] * p.x + r[1][i] * p.y + r[2][i] * p.z;  // (R^T p)_i
    for (int j = 0; j < 3; ++j) b[i][j] = r[j][i] - projected * g[j];
  }
  times_point_jacobian(b, p, h);
  return is_singular;
}

// What a row's variance must be for the match to be valid; a row that it does not have may be anything.
template <ThirdRow third>
inline Mask is_positive_definite(const Doubles& pivot, int row, const Mask& has_third) {
  const Mask is_above_zero = pivot > Doubles(0.0);
  return third != ThirdRow::none && row == 2 ? is_above_zero | !has_third : is_above_zero;
}

// H_x / sigma. Returns where a variance has underflowed to zero.
template <ThirdRow third, int Rows>
inline Mask measurement_block(const BlockInput& input, const Tile& tile, std::size_t i, const Point& p,
                              const Mask& has_third, Doubles (&h)[Rows][dimension]) {
  Doubles j[Rows][3];
  projection_jacobian<third>(input, p, j);
  times_point_jacobian(j, p, h);
  Mask is_definite(true);
  for (int row = 0; row < Rows; ++row) {
    const bool is_depth = third == ThirdRow::depth && row == 2;
    if (!is_depth && input.sigmas == nullptr) continue;  // 1
    const Doubles sigma = is_depth ? Doubles(input.depth_sigma) : load(tile.sigma, i);
    const Doubles variance = sigma * sigma;
    const Doubles deviation = xsimd::sqrt(variance);
    is_definite = is_definite & is_positive_definite<third>(variance, row, has_third);
    for (Doubles& entry : h[row]) entry = entry / deviation;
  }
  return is_definite;
}

// Adds H_p Sigma_p H_p^T, H_p = J R, to the lower triangle; sigma^2 J R (J R)^T where no covariance is given.
template <int Rows>
inline void add_map_covariance(const BlockInput& input, const Tile& tile, std::size_t i, const Doubles (&j)[Rows][3],
                               Doubles (&covariance)[Rows][Rows]) {
  Doubles h_p[Rows][3];
  for (int a = 0; a < Rows; ++a) {
    for (int c = 0; c < 3; ++c) {
      h_p[a][c] = j[a][0] * Doubles(input.T_cw[c]) + j[a][1] * Doubles(input.T_cw[4 + c]) +
                  j[a][2] * Doubles(input.T_cw[8 + c]);
    }
  }
  const bool is_isotropic = input.map_covariances == nullptr;
  const Doubles variance(input.map_sigma * input.map_sigma);
  for (int a = 0; a < Rows; ++a) {
    for (int c = 0; c < 3; ++c) {
      if (is_isotropic) {
        const Doubles product = variance * h_p[a][c];
        for (int b = 0; b <= a; ++b) covariance[a][b] += product * h_p[b][c];
      } else {
        for (int d = 0; d < 3; ++d) {
          const Doubles product = h_p[a][c] * load(tile.map_covariance[3 * c + d], i);
          for (int b = 0; b <= a; ++b) covariance[a][b] += product * h_p[b][d];
        }
      }
    }
  }
}

// C^-1 H_x by forward substitution, C C^T the covariance of both noises. Returns where that is positive definite.
template <ThirdRow third, int Rows>
inline Mask whitened_block(const BlockInput& input, const Tile& tile, std::size_t i, const Point& p,
                           const Mask& has_third, Doubles (&h)[Rows][dimension]) {
  Doubles j[Rows][3];
  projection_jacobian<third>(input, p, j);
  times_point_jacobian(j, p, h);
  Doubles c[Rows][Rows];  // the lower triangle of the covariance, then its factor
  const Doubles sigma = input.sigmas == nullptr ? Doubles(1.0) : load(tile.sigma, i);
  for (int a = 0; a < Rows; ++a) {
    for (int b = 0; b < a; ++b) c[a][b] = Doubles(0.0);
    const Doubles deviation = third == ThirdRow::depth && a == 2 ? Doubles(input.depth_sigma) : sigma;
    c[a][a] = deviation * deviation;
  }
  add_map_covariance(input, tile, i, j, c);
  Mask is_definite(true);
  for (int a = 0; a < Rows; ++a) {
    for (int b = 0; b <= a; ++b) {
      for (int d = 0; d < b; ++d) c[a][b] -= c[a][d] * c[b][d];
      if (b < a) c[a][b] = c[a][b] / c[b][b];
    }
    is_definite = is_definite & is_positive_definite<third>(c[a][a], a, has_third);
    c[a][a] = xsimd::sqrt(c[a][a]);
    for (int column = 0; column < dimension; ++column) {
      for (int d = 0; d < a; ++d) h[a][column] -= c[a][d] * h[d][column];
      h[a][column] = h[a][column] / c[a][a];
    }
  }
  return is_definite;
}

template <int Rows>
inline void clear_where_not(const Mask& kept, Doubles (&h)[Rows][dimension]) {
  for (auto& row : h) {
    for (Doubles& entry : row) entry = xsimd::select(kept, entry, Doubles(0.0));
  }
}

// Magnitudes of what was stored: by column the largest, and their sum, which is finite if all of them are.
struct Magnitudes {
  Doubles columns[dimension];
  Doubles sum;
};

template <int Rows>
inline Magnitudes store(const Doubles (&h)[Rows][dimension], float* entries, std::size_t stride) {
  Magnitudes magnitudes;
  Doubles sums[Rows];
  for (int row = 0; row < Rows; ++row) {
    for (int column = 0; column < dimension; ++column) {
      const Doubles::register_type exact = h[row][column];
      const Narrow rounded = __builtin_convertvector(exact, Narrow);
      std::memcpy(entries + static_cast<std::size_t>(dimension * row + column) * stride, &rounded, sizeof rounded);
      const Doubles stored(__builtin_convertvector(rounded, Doubles::register_type));
      const Doubles magnitude = xsimd::abs(stored);
      sums[row] = column == 0 ? magnitude : sums[row] + magnitude;
      magnitudes.columns[column] = row == 0 ? magnitude : xsimd::max(magnitudes.columns[column], magnitude);
    }
  }
  magnitudes.sum = sums[0];
  for (int row = 1; row < Rows; ++row) magnitudes.sum += sums[row];
  return magnitudes;
}

inline double largest_lane(const Doubles& values) {
  alignas(sizeof(Doubles)) double entries[double_lanes];
  values.store_aligned(entries);
  double largest = entries[0];
  for (const double entry : entries) largest = entry > largest ? entry : largest;
  return largest;
}

inline std::size_t count_lanes(const Mask& mask, std::size_t used) {
  alignas(sizeof(Doubles)) double ones[double_lanes];
  xsimd::select(mask, Doubles(1.0), Doubles(0.0)).store_aligned(ones);
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < used; ++lane) count += ones[lane] != 0 ? 1 : 0;
  return count;
}

inline void store_validity(const Mask& valid, std::size_t used, unsigned char* validity) {
  alignas(sizeof(Doubles)) double ones[double_lanes];
  xsimd::select(valid, Doubles(1.0), Doubles(0.0)).store_aligned(ones);
  for (std::size_t lane = 0; lane < used; ++lane) validity[lane] = ones[lane] != 0 ? 1 : 0;
}

template <BlockWeighting weighting, ThirdRow third>
void build_blocks_of(const BlockInput& input, BlockOutput& output) {
  constexpr bool is_world = weighting == BlockWeighting::map_bias_world;
  constexpr int rows = third == ThirdRow::none && !is_world ? 2 : 3;
  const Doubles zero(0.0);
  Tile tile;
  Doubles column_max[dimension];
  for (Doubles& magnitude : column_max) magnitude = zero;
  Mask is_any_tall(false);
  output.invalid = output.behind_camera = output.singular_rays = 0;

  for (std::size_t i = 0; i < input.size; i += double_lanes) {
    const std::size_t in_tile = i % tile_matches;
    if (in_tile == 0) {
      const std::size_t rest = input.size - i;
      fill<weighting, third>(tile, input, i, rest < tile_matches ? rest : tile_matches);
    }
    const std::size_t used = input.size - i < double_lanes ? input.size - i : double_lanes;

    const Point p = transform(input.T_cw, tile, in_tile);
    Mask valid = is_positive(p.z) & is_finite(p.x) & is_finite(p.y);
    if (input.sigmas != nullptr) valid = valid & is_positive(load(tile.sigma, in_tile));
    if (input.weights != nullptr) valid = valid & (load(tile.weight, in_tile) >= zero);
    if (input.usable != nullptr) valid = valid & (load(tile.usable, in_tile) > zero);
    Mask has_third(third != ThirdRow::none);
    if (third != ThirdRow::none && input.has_third != nullptr) has_third = load(tile.has_third, in_tile) > zero;

    Doubles h[rows][dimension];
    Mask is_singular(false);
    if constexpr (weighting == BlockWeighting::map_bias) {
      map_bias_block<third>(p, has_third, h);
    } else if constexpr (is_world) {
      is_singular = valid & map_bias_world_block<third>(input.T_cw, p, has_third, h);
      valid = valid & !is_singular;
    } else if constexpr (weighting == BlockWeighting::measurement) {
      valid = valid & measurement_block<third>(input, tile, in_tile, p, has_third, h);
    } else {
      valid = valid & whitened_block<third>(input, tile, in_tile, p, has_third, h);
    }
    if (input.weights != nullptr) {
      const Doubles root_weight = xsimd::sqrt(load(tile.weight, in_tile));
      for (auto& row : h) {
        for (Doubles& entry : row) entry *= root_weight;
      }
    }
    if constexpr (third != ThirdRow::none && !is_world) {
      for (Doubles& entry : h[2]) entry = xsimd::select(has_third, entry, zero);
    }

    // A plane may end with the last match, so a pack that is not full goes there by a detour.
    float last[rows * dimension * double_lanes];
    const bool is_full = used == double_lanes;
    float* const entries = is_full ? output.planes + i : last;
    const std::size_t stride = is_full ? output.stride : double_lanes;
    const bool are_all_computed = xsimd::all(valid);
    if (!are_all_computed) clear_where_not(valid, h);
    Magnitudes stored;
    bool are_all_held = true;
    for (;;) {  // again only where float32 cannot hold a block
      stored = store(h, entries, stride);
      const Mask is_held = is_finite(stored.sum);
      if (xsimd::all(is_held)) break;
      are_all_held = false;
      clear_where_not(is_held, h);
      valid = valid & is_held;
    }
    for (int c = 0; c < dimension; ++c) column_max[c] = xsimd::max(column_max[c], stored.columns[c]);
    is_any_tall = is_any_tall | (valid & has_third);

    if (!is_full) {
      for (std::size_t plane = 0; plane < rows * dimension; ++plane) {
        std::memcpy(output.planes + plane * output.stride + i, last + plane * double_lanes, used * sizeof(float));
      }
    }
    if (are_all_computed && are_all_held && is_full) {
      std::memset(output.validity + i, 1, double_lanes);
    } else {
      store_validity(valid, used, output.validity + i);
      output.invalid += used - count_lanes(valid, used);
      Mask is_behind = p.z <= zero;
      if (input.usable != nullptr) is_behind = is_behind & (load(tile.usable, in_tile) > zero);
      output.behind_camera += count_lanes(is_behind, used);
      output.singular_rays += count_lanes(is_singular, used);
    }
  }

  const bool is_tall = is_world || xsimd::any(is_any_tall);
  output.rows_written = rows;
  output.rows = output.invalid == input.size ? 0 : (is_tall ? 3 : 2);
  for (int c = 0; c < dimension; ++c) output.column_max[c] = largest_lane(column_max[c]);
}

template <BlockWeighting weighting>
void build_blocks_weighted(const BlockInput& input, BlockOutput& output) {
  // Both weightings by the map's bias ask only whether a match has a third measurement.
  constexpr bool is_map_bias = weighting == BlockWeighting::map_bias || weighting == BlockWeighting::map_bias_world;
  switch (input.third) {
    case ThirdRow::none: return build_blocks_of<weighting, ThirdRow::none>(input, output);
    case ThirdRow::stereo: return build_blocks_of<weighting, ThirdRow::stereo>(input, output);
    case ThirdRow::depth:
      return build_blocks_of < weighting, is_map_bias ? ThirdRow::stereo : ThirdRow::depth > (input, output);
  }
}

void build_blocks(const BlockInput& input, BlockOutput& output) {
  switch (input.weighting) {
    case BlockWeighting::map_bias: return build_blocks_weighted<BlockWeighting::map_bias>(input, output);
    case BlockWeighting::map_bias_world: return build_blocks_weighted<BlockWeighting::map_bias_world>(input, output);
    case BlockWeighting::measurement: return build_blocks_weighted<BlockWeighting::measurement>(input, output);
    case BlockWeighting::measurement_and_map:
      return build_blocks_weighted<BlockWeighting::measurement_and_map>(input, output);
  }
}

}  // namespace
