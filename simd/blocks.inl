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

// The input of some matches, an array per value, so that packs load whole vectors. Well before they do: a vector load
// right after the scalar stores it reads from would stall. Up to a whole pack the last match is repeated, which no
// maximum notices.
constexpr std::size_t tile_matches = 64;
static_assert(tile_matches % double_lanes == 0, "a tile holds whole packs");

struct Tile {
  std::size_t count;
  std::uint32_t number[tile_matches];         // of the match
  alignas(64) double point[3][tile_matches];  // in the world, then in the camera frame
  alignas(64) double sigma[tile_matches];
  alignas(64) double weight[tile_matches];
  alignas(64) double has_third[tile_matches];
  alignas(64) double map_covariance[6][tile_matches];  // upper triangle, by rows
};
constexpr std::size_t upper_triangle[6] = {0, 1, 2, 4, 5, 8};  // of 3 x 3, row-major

inline Doubles load(const double (&values)[tile_matches], std::size_t i) { return Doubles::load_aligned(values + i); }

inline void repeat_last(double (&values)[tile_matches], std::size_t count) {
  for (std::size_t i = count; i % double_lanes != 0; ++i) values[i] = values[count - 1];
}

// Lists usable matches from `next` on, as many as there is room for; returns where to go on.
inline std::size_t list_usable(const BlockInput& input, std::size_t next, Tile& tile) {
  tile.count = 0;
  if (input.usable == nullptr) {
    for (; next < input.size && tile.count < tile_matches; ++next) {
      tile.number[tile.count++] = static_cast<std::uint32_t>(next);
    }
    return next;
  }
  for (; next < input.size && tile.count < tile_matches; ++next) {
    tile.number[tile.count] = static_cast<std::uint32_t>(next);
    tile.count += input.usable[next] != 0 ? 1 : 0;
  }
  return next;
}

template <std::size_t entries, class T>
inline void fill(double (&values)[tile_matches], const T* source, std::size_t entry, const Tile& tile) {
  for (std::size_t i = 0; i < tile.count; ++i)
    values[i] = static_cast<double>(source[entries * tile.number[i] + entry]);
  repeat_last(values, tile.count);
}

template <BlockWeighting weighting, ThirdRow third>
inline void fill(const BlockInput& input, Tile& tile) {
  for (std::size_t i = 0; i < tile.count; ++i) {
    const double* const point = input.points + std::size_t{3} * tile.number[i];
    for (std::size_t d = 0; d < 3; ++d) tile.point[d][i] = point[d];
  }
  for (auto& coordinate : tile.point) repeat_last(coordinate, tile.count);
  if (input.sigmas != nullptr) fill<1>(tile.sigma, input.sigmas, 0, tile);
  if (input.weights != nullptr) fill<1>(tile.weight, input.weights, 0, tile);
  if (third != ThirdRow::none && input.has_third != nullptr) fill<1>(tile.has_third, input.has_third, 0, tile);
  if (weighting == BlockWeighting::measurement_and_map && input.map_covariances != nullptr) {
    for (std::size_t i = 0; i < tile.count; ++i) {
      const double* const covariance = input.map_covariances + std::size_t{9} * tile.number[i];
      for (std::size_t e = 0; e < 6; ++e) tile.map_covariance[e][i] = covariance[upper_triangle[e]];
    }
    for (auto& entry : tile.map_covariance) repeat_last(entry, tile.count);
  }
}

struct Point {
  Doubles x, y, z;
};

inline Point load_point(const Tile& tile, std::size_t i) {
  return {load(tile.point[0], i), load(tile.point[1], i), load(tile.point[2], i)};
}

inline Point transform(const double* T_cw, const Point& world) {
  Doubles p[3];
  for (int row = 0; row < 3; ++row) {
    const double* const r = T_cw + 4 * row;
    p[row] = Doubles(r[0]) * world.x + Doubles(r[1]) * world.y + Doubles(r[2]) * world.z + Doubles(r[3]);
  }
  return {p[0], p[1], p[2]};
}

inline std::uint32_t lanes_of(const Mask& mask) {
  alignas(sizeof(Doubles)) double ones[double_lanes];
  xsimd::select(mask, Doubles(1.0), Doubles(0.0)).store_aligned(ones);
  std::uint32_t lanes = 0;
  for (std::size_t lane = 0; lane < double_lanes; ++lane) lanes |= ones[lane] != 0 ? 1U << lane : 0U;
  return lanes;
}

template <std::size_t size>
inline void keep(double (&values)[size], const std::uint32_t* kept, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] = values[kept[i]];
  if (count > 0) repeat_last(values, count);
}

// Takes points to the camera frame, and out of the tile the matches that have no Jacobian there, or no weight.
inline void transform_and_sift(const BlockInput& input, Tile& tile, BlockOutput& output) {
  std::uint32_t kept[tile_matches];
  std::size_t count = 0;
  for (std::size_t i = 0; i < tile.count; i += double_lanes) {
    const std::size_t used = tile.count - i < double_lanes ? tile.count - i : double_lanes;
    const Point p = transform(input.T_cw, load_point(tile, i));
    p.x.store_aligned(tile.point[0] + i);
    p.y.store_aligned(tile.point[1] + i);
    p.z.store_aligned(tile.point[2] + i);
    Mask valid = is_positive(p.z) & is_finite(p.x) & is_finite(p.y);
    if (input.sigmas != nullptr) valid = valid & is_positive(load(tile.sigma, i));
    if (input.weights != nullptr) valid = valid & (load(tile.weight, i) >= Doubles(0.0));
    if (xsimd::all(valid)) {
      for (std::size_t lane = 0; lane < used; ++lane) kept[count++] = static_cast<std::uint32_t>(i + lane);
      continue;
    }
    const std::uint32_t valid_lanes = lanes_of(valid);
    const std::uint32_t behind = lanes_of(p.z <= Doubles(0.0));
    for (std::uint32_t lane = 0; lane < used; ++lane) {
      kept[count] = static_cast<std::uint32_t>(i) + lane;
      count += valid_lanes >> lane & 1U;
      output.behind_camera += behind >> lane & 1U;
    }
  }
  if (count == tile.count) return;
  for (std::size_t i = 0; i < count; ++i) tile.number[i] = tile.number[kept[i]];
  for (auto& coordinate : tile.point) keep(coordinate, kept, count);
  keep(tile.sigma, kept, count);
  keep(tile.weight, kept, count);
  keep(tile.has_third, kept, count);
  for (auto& entry : tile.map_covariance) keep(entry, kept, count);
  tile.count = count;
}

// A block is A [ I | -[p]x ], with an upper triangular A: its rows are those of the measurements but for a rotation
// among them, which no gain notices, and which keeps them from being nearly parallel (u and u_right would be).
template <int Rows>
struct Factor {
  Doubles a[Rows][3];  // zero below the diagonal, and not read there
};

// The same from its share in coordinates along the ray, (dX - X / Z dZ, dY - Y / Z dZ, dZ).
template <int Rows>
inline void from_ray(const Doubles& x, const Doubles& y, Factor<Rows>& factor) {
  factor.a[0][2] = factor.a[0][2] - factor.a[0][0] * x - factor.a[0][1] * y;
  factor.a[1][2] = factor.a[1][2] - factor.a[1][1] * y;
}

template <int Rows>
inline void multiply_by_point_jacobian(const Factor<Rows>& factor, const Point& p, Doubles (&h)[Rows][dimension]) {
  const Doubles zero(0.0);
  h[0][0] = factor.a[0][0];
  h[0][1] = factor.a[0][1];
  h[0][2] = factor.a[0][2];
  h[0][3] = h[0][2] * p.y - h[0][1] * p.z;
  h[0][4] = h[0][0] * p.z - h[0][2] * p.x;
  h[0][5] = h[0][1] * p.x - h[0][0] * p.y;
  h[1][0] = zero;
  h[1][1] = factor.a[1][1];
  h[1][2] = factor.a[1][2];
  h[1][3] = h[1][2] * p.y - h[1][1] * p.z;
  h[1][4] = negated(h[1][2] * p.x);
  h[1][5] = h[1][1] * p.x;
  if constexpr (Rows == 3) {
    h[2][0] = zero;
    h[2][1] = zero;
    h[2][2] = factor.a[2][2];
    h[2][3] = h[2][2] * p.y;
    h[2][4] = negated(h[2][2] * p.x);
    h[2][5] = zero;
  }
}

// H_c in the camera frame: H_p^n^-1 = [J; 0 0 1]^-1, and the row of zeros that the paper appends to H_x leaves
// [1 0 -X/Z; 0 1 -Y/Z; 0 0 0] of it. fx and fy cancel. With a third measurement J^-1 J = I is left.
template <ThirdRow third, int Rows>
inline Factor<Rows> map_bias_factor(const Point& p, const Mask& has_third) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  Factor<Rows> factor;
  factor.a[0][0] = factor.a[1][1] = one;
  factor.a[0][1] = zero;
  factor.a[0][2] = negated(p.x / p.z);
  factor.a[1][2] = negated(p.y / p.z);
  if constexpr (third != ThirdRow::none) {
    factor.a[0][2] = xsimd::select(has_third, zero, factor.a[0][2]);
    factor.a[1][2] = xsimd::select(has_third, zero, factor.a[1][2]);
    factor.a[2][2] = xsimd::select(has_third, one, zero);
  }
  return factor;
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
  for (int i = 0; i < 3; ++i) {
    const Doubles projected = r[0][i] * p.x + r[1][i] * p.y + r[2][i] * p.z;  // (R^T p)_i
    Doubles b[3];
    for (int j = 0; j < 3; ++j) b[j] = r[j][i] - projected * g[j];
    for (int j = 0; j < 3; ++j) h[i][j] = b[j];
    h[i][3] = b[2] * p.y - b[1] * p.z;
    h[i][4] = b[0] * p.z - b[2] * p.x;
    h[i][5] = b[1] * p.x - b[0] * p.y;
  }
  return is_singular;
}

// A symmetric 3 x 3 matrix.
struct Symmetric {
  Doubles xx, xy, xz, yy, yz, zz;
};

inline void add(const Symmetric& from, Symmetric& to) {
  to.xx += from.xx;
  to.xy += from.xy;
  to.xz += from.xz;
  to.yy += from.yy;
  to.yz += from.yz;
  to.zz += from.zz;
}

// R Sigma_p R^T.
inline Symmetric in_camera_frame(const double* T_cw, const Tile& tile, std::size_t i) {
  Doubles s[6];
  for (int e = 0; e < 6; ++e) s[e] = load(tile.map_covariance[e], i);
  constexpr int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};  // of Sigma_p
  Doubles rows[3][3];                                          // R Sigma_p
  for (int a = 0; a < 3; ++a) {
    const double* const r = T_cw + 4 * a;
    for (int c = 0; c < 3; ++c) {
      rows[a][c] = Doubles(r[0]) * s[at[0][c]] + Doubles(r[1]) * s[at[1][c]] + Doubles(r[2]) * s[at[2][c]];
    }
  }
  const auto entry = [&](int a, int b) {
    const double* const r = T_cw + 4 * b;
    return rows[a][0] * Doubles(r[0]) + rows[a][1] * Doubles(r[1]) + rows[a][2] * Doubles(r[2]);
  };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

// V S V^T with V = [1 0 -x; 0 1 -y; 0 0 1]: from the camera's axes to (dX - x dZ, dY - y dZ, dZ).
inline Symmetric along_ray(const Symmetric& s, const Doubles& x, const Doubles& y) {
  const Doubles xz = s.xz - x * s.zz;
  const Doubles yz = s.yz - y * s.zz;
  return {s.xx - x * (s.xz + xz), s.xy - y * s.xz - x * yz, xz, s.yy - y * (s.yz + yz), yz, s.zz};
}

// Where the measurement puts the point, along its ray: dX - x dZ = Z / fx du, dY - y dZ = Z / fy dv, and dZ = -Z^2 / bf
// (du - du_right) of a stereo row, or that of the depth. Returns where a variance has underflowed to zero.
template <ThirdRow third>
inline Mask measured_along_ray(const BlockInput& input, const Doubles& sigma, const Point& p, const Mask& has_third,
                               Symmetric& s) {
  const Doubles zero(0.0);
  const Doubles variance = sigma * sigma;
  const Doubles a = p.z * Doubles(1 / input.fx);
  const Doubles b = p.z * Doubles(1 / input.fy);
  s.xx = a * a * variance;
  s.yy = b * b * variance;
  s.xy = s.xz = s.yz = s.zz = zero;
  Mask is_definite = variance > zero;
  if constexpr (third == ThirdRow::stereo) {
    const Doubles per_pixel = p.z * p.z * Doubles(1 / input.bf);
    s.xz = negated(a * per_pixel * variance);
    s.zz = per_pixel * per_pixel * (variance + variance);
  } else if constexpr (third == ThirdRow::depth) {
    s.zz = Doubles(input.depth_sigma * input.depth_sigma);
    is_definite = is_definite & ((s.zz > zero) | !has_third);
  }
  return is_definite;
}

// A with A^T A = S^-1, along the ray, from S = U U^T, U upper triangular; without a third measurement of the
// information about the first two coordinates alone, S being what it would be then. Returns where S is positive
// definite.
template <ThirdRow third, int Rows>
inline Mask whiten(const Symmetric& s, const Mask& has_third, Factor<Rows>& factor) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  Doubles xz = zero, yz = zero, inverse_zz = zero;
  Mask is_definite(true);
  if constexpr (Rows == 3) {
    is_definite = is_positive(s.zz) | !has_third;
    inverse_zz = xsimd::select(has_third, one / xsimd::sqrt(s.zz), zero);
    xz = xsimd::select(has_third, s.xz * inverse_zz, zero);
    yz = xsimd::select(has_third, s.yz * inverse_zz, zero);
  }
  const Doubles yy = s.yy - yz * yz;
  const Doubles inverse_yy = one / xsimd::sqrt(yy);
  const Doubles xy = (s.xy - xz * yz) * inverse_yy;
  const Doubles xx = s.xx - xz * xz - xy * xy;
  const Doubles inverse_xx = one / xsimd::sqrt(xx);
  is_definite = is_definite & is_positive(yy) & is_positive(xx);
  factor.a[0][0] = inverse_xx;
  factor.a[0][1] = negated(xy * inverse_yy * inverse_xx);
  factor.a[1][1] = inverse_yy;
  factor.a[0][2] = factor.a[1][2] = zero;
  if constexpr (Rows == 3) {
    factor.a[1][2] = negated(yz * inverse_zz * inverse_yy);
    factor.a[0][2] = negated((xz * inverse_xx + yz * factor.a[0][1]) * inverse_zz);
    factor.a[2][2] = inverse_zz;
  }
  return is_definite;
}

// Q H_x / sigma, with a rotation Q: with a stereo row of ((u + u_right) / sqrt(2), v, (u_right - u) / sqrt(2)), of
// which the last sees nothing but the depth. Returns where sigma^2 has underflowed to zero.
template <ThirdRow third, int Rows>
inline Mask measurement_factor(const BlockInput& input, const Tile& tile, std::size_t i, const Point& p,
                               const Mask& has_third, Factor<Rows>& factor) {
  constexpr double root_half = 0.70710678118654752;
  const Doubles zero(0.0);
  const Doubles inverse_z = Doubles(1.0) / p.z;
  Mask is_definite(true);
  Doubles weight = inverse_z;
  if (input.sigmas != nullptr) {
    const Doubles sigma = load(tile.sigma, i);
    is_definite = sigma * sigma > zero;
    weight = inverse_z / sigma;
  }
  Doubles column = Doubles(input.fx) * weight;
  factor.a[0][1] = factor.a[0][2] = factor.a[1][2] = zero;
  factor.a[1][1] = Doubles(input.fy) * weight;
  if constexpr (third == ThirdRow::stereo) {
    const Doubles depth = Doubles(input.bf * root_half) * (inverse_z * weight);
    column = xsimd::select(has_third, column * Doubles(2 * root_half), column);
    factor.a[2][2] = xsimd::select(has_third, depth, zero);
    factor.a[0][2] = factor.a[2][2];
  } else if constexpr (third == ThirdRow::depth) {
    is_definite = is_definite & ((Doubles(input.depth_sigma * input.depth_sigma) > zero) | !has_third);
    factor.a[2][2] = xsimd::select(has_third, Doubles(1 / input.depth_sigma), zero);
  }
  factor.a[0][0] = column;
  from_ray(p.x * inverse_z, p.y * inverse_z, factor);
  return is_definite;
}

// Q C^-1 H_x with C C^T = Sigma_z + H_p Sigma_p H_p^T: of the point's covariance as measured and as mapped, together.
template <ThirdRow third, int Rows>
inline Mask whitened_factor(const BlockInput& input, const Tile& tile, std::size_t i, const Point& p,
                            const Mask& has_third, Factor<Rows>& factor) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles sigma = input.sigmas == nullptr ? one : load(tile.sigma, i);
  const Doubles inverse_z = one / p.z;
  const Doubles x = p.x * inverse_z;
  const Doubles y = p.y * inverse_z;
  Symmetric s;
  Mask is_definite = measured_along_ray<third>(input, sigma, p, has_third, s);
  if (input.map_covariances == nullptr) {
    const Doubles variance(input.map_sigma * input.map_sigma);
    add(along_ray({variance, zero, zero, variance, zero, variance}, x, y), s);
  } else {
    add(along_ray(in_camera_frame(input.T_cw, tile, i), x, y), s);
  }
  is_definite = is_definite & whiten<third>(s, has_third, factor);
  from_ray(x, y, factor);
  return is_definite;
}

// Whether float32 holds every entry; none is above this sum of products.
template <int Rows>
inline bool all_surely_held(const Doubles (&h)[Rows][dimension]) {
  Doubles sum(0.0);
  for (const auto& row : h) {
    for (const Doubles& entry : row) sum += xsimd::abs(entry);
  }
  return xsimd::all(sum < Doubles(1e38));
}

template <int Rows>
inline Mask are_held(const Doubles (&h)[Rows][dimension]) {
  Mask held(true);
  for (const auto& row : h) {
    for (const Doubles& entry : row) {
      const Doubles::register_type exact = entry;
      const Narrow rounded = __builtin_convertvector(exact, Narrow);
      held = held & is_finite(Doubles(__builtin_convertvector(rounded, Doubles::register_type)));
    }
  }
  return held;
}

template <int Rows>
inline void store(const Doubles (&h)[Rows][dimension], float* entries, std::size_t stride) {
  for (int row = 0; row < Rows; ++row) {
    for (int column = 0; column < dimension; ++column) {
      const Doubles::register_type exact = h[row][column];
      const Narrow rounded = __builtin_convertvector(exact, Narrow);
      std::memcpy(entries + static_cast<std::size_t>(dimension * row + column) * stride, &rounded, sizeof rounded);
    }
  }
}

inline void store_point(const Point& p, float* to, std::size_t stride) {
  const Doubles* const coordinates[3] = {&p.x, &p.y, &p.z};
  for (std::size_t d = 0; d < 3; ++d) {
    const Doubles::register_type exact = *coordinates[d];
    const Narrow rounded = __builtin_convertvector(exact, Narrow);
    std::memcpy(to + d * stride, &rounded, sizeof rounded);
  }
}

// The largest |value|, none of which is NaN.
inline float largest_magnitude(const float* values, std::size_t count) {
  Floats most(0.0F);
  std::size_t i = 0;
  for (; i + float_lanes <= count; i += float_lanes) {
    most = xsimd::max(most, xsimd::abs(Floats::load_unaligned(values + i)));
  }
  float largest = largest_lane(most);
  for (; i < count; ++i) {
    const float magnitude = values[i] < 0 ? -values[i] : values[i];
    largest = magnitude > largest ? magnitude : largest;
  }
  return largest;
}

template <BlockWeighting weighting, ThirdRow third>
void build_blocks_of(const BlockInput& given, BlockOutput& output) {
  constexpr bool is_world = weighting == BlockWeighting::map_bias_world;
  constexpr int rows = third == ThirdRow::none && !is_world ? 2 : 3;
  constexpr bool is_factored = rows == 3 && !is_world;
  constexpr std::size_t entries = std::size_t{rows} * dimension;
  const Doubles zero(0.0);
  double pose[12];  // copies, which nothing that is written can change
  for (int e = 0; e < 12; ++e) pose[e] = given.T_cw[e];
  BlockInput input = given;
  input.T_cw = pose;
  Tile tile;
  bool is_any_tall = is_world;
  output.stored = output.behind_camera = output.singular_rays = 0;
  std::memset(output.validity, 0, input.size);

  for (std::size_t next = 0; next < input.size;) {
    next = list_usable(input, next, tile);
    if (tile.count == 0) break;
    fill<weighting, third>(input, tile);
    transform_and_sift(input, tile, output);

    for (std::size_t i = 0; i < tile.count; i += double_lanes) {
      const std::size_t used = tile.count - i < double_lanes ? tile.count - i : double_lanes;
      const Point p = load_point(tile, i);
      Mask has_third(third != ThirdRow::none);
      if (third != ThirdRow::none && input.has_third != nullptr) has_third = load(tile.has_third, i) > zero;

      Doubles h[rows][dimension];
      Mask valid(true);
      Mask is_singular(false);
      if constexpr (is_world) {
        is_singular = map_bias_world_block<third>(input.T_cw, p, has_third, h);
        valid = !is_singular;
      } else {
        Factor<rows> factor;
        if constexpr (weighting == BlockWeighting::map_bias) {
          factor = map_bias_factor<third, rows>(p, has_third);
        } else if constexpr (weighting == BlockWeighting::measurement) {
          valid = measurement_factor<third>(input, tile, i, p, has_third, factor);
        } else {
          valid = whitened_factor<third>(input, tile, i, p, has_third, factor);
        }
        multiply_by_point_jacobian(factor, p, h);
      }
      if (input.weights != nullptr) {
        const Doubles root_weight = xsimd::sqrt(load(tile.weight, i));
        for (auto& row : h) {
          for (Doubles& entry : row) entry *= root_weight;
        }
      }

      float* const planes = output.planes + output.stored;
      std::uint32_t* const indices = output.indices + output.stored;
      if (used == double_lanes && xsimd::all(valid) && all_surely_held(h)) {
        store(h, planes, output.stride);
        if (is_factored) store_point(p, planes + point_plane * output.stride, output.stride);
        for (std::size_t lane = 0; lane < double_lanes; ++lane) {
          indices[lane] = output.first_index + tile.number[i + lane];
          output.validity[tile.number[i + lane]] = 1;
        }
        output.stored += double_lanes;
        is_any_tall = is_any_tall || (third != ThirdRow::none && xsimd::any(has_third));
        continue;
      }
      // A pack that is not full, or has matches without a block, goes there by a detour.
      float detour[entries * double_lanes];
      float point[3 * double_lanes];
      store(h, detour, double_lanes);
      store_point(p, point, double_lanes);
      const std::uint32_t valid_lanes = lanes_of(valid & are_held(h));
      const std::uint32_t tall_lanes = lanes_of(has_third);
      const std::uint32_t singular_lanes = lanes_of(is_singular);
      std::size_t kept = 0;
      for (std::size_t lane = 0; lane < used; ++lane) {
        output.singular_rays += singular_lanes >> lane & 1U;
        if ((valid_lanes >> lane & 1U) == 0) continue;
        for (std::size_t e = 0; e < entries; ++e) planes[e * output.stride + kept] = detour[e * double_lanes + lane];
        for (std::size_t d = 0; is_factored && d < 3; ++d) {
          planes[(point_plane + d) * output.stride + kept] = point[d * double_lanes + lane];
        }
        indices[kept++] = output.first_index + tile.number[i + lane];
        output.validity[tile.number[i + lane]] = 1;
        is_any_tall = is_any_tall || (tall_lanes >> lane & 1U) != 0;
      }
      output.stored += kept;
    }
  }

  output.rows_written = rows;
  output.rows = output.stored == 0 ? 0 : (is_any_tall ? 3 : 2);
  for (std::size_t column = 0; column < dimension; ++column) {
    float largest = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      const float* const plane = output.planes + (dimension * row + column) * output.stride;
      const float of_row = largest_magnitude(plane, output.stored);
      largest = of_row > largest ? of_row : largest;
    }
    output.column_max[column] = static_cast<double>(largest);
  }
  output.is_factored = is_factored && factored_max({output.planes, output.stride}, output.stored, output.factored_max);
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
