// SPDX-License-Identifier: MIT
// Matches that cameras of any model see, one of them or a rig's: J = d z / d p_b, p_b the point in the body's frame, by
// the camera's model or as the caller gives it. What makes a block of it does not ask for the model.

namespace {

using maxlogdet::simd::CameraInput;
using maxlogdet::simd::Projection;

// Why a match has no J; a double, so that it is kept as all else of a tile.
constexpr double is_seen = 0;
constexpr double is_behind = 1;
constexpr double is_too_near = 2;
constexpr double has_no_jacobian = 3;

struct SeenTile : Tile {
  alignas(64) double camera[tile_matches];  // its number
  std::uint64_t cameras[4];                 // a bit for each that there is a match of
  alignas(64) double sight[tile_matches];
  alignas(64) double jacobian[9][tile_matches];  // first the caller's by p_c, 2 x 3, then J by p_b, 3 x 3
  alignas(64) double ray[3][tile_matches];       // from the camera to the point, in the body's axes; map_bias_world
};

inline void fill_seen(const BlockInput& input, SeenTile& tile) {
  for (std::uint64_t& cameras : tile.cameras) cameras = 0;
  tile.cameras[0] = 1;
  if (input.camera_ids != nullptr) {
    tile.cameras[0] = 0;
    fill<1>(tile.camera, input.camera_ids, 0, tile);
    for (std::size_t i = 0; i < tile.count; ++i) {
      const unsigned char camera = input.camera_ids[tile.number[i]];
      tile.cameras[camera / 64U] |= std::uint64_t{1} << (camera % 64U);
    }
  }
  if (input.jacobians != nullptr) {
    for (std::size_t e = 0; e < 6; ++e) fill<6>(tile.jacobian[e], input.jacobians, e, tile);
  }
}

// d (m_x, m_y) / d p_c, and where the model has an image; u = fx m_x + cx, v = fy m_y + cy.
struct Image {
  Doubles x[3], y[3];
  Mask exists;
};

inline Image pinhole(const Point& p) {
  const Doubles zero(0.0);
  const Doubles inverse_z = Doubles(1.0) / p.z;
  return {{inverse_z, zero, negated(p.x * inverse_z * inverse_z)},
          {zero, inverse_z, negated(p.y * inverse_z * inverse_z)},
          p.z > zero};
}

// With x = X / Z, y = Y / Z, G = d (m_x, m_y) / d (x, y) is symmetric; where it is not positive, the image is folded.
inline Image radial_tangential(const double* k, const Point& p) {
  const Doubles zero(0.0);
  const Doubles inverse_z = Doubles(1.0) / p.z;
  const Doubles x = p.x * inverse_z;
  const Doubles y = p.y * inverse_z;
  const Doubles rho = x * x + y * y;
  const Doubles radial = Doubles(1.0) + rho * (Doubles(k[0]) + rho * (Doubles(k[1]) + rho * Doubles(k[4])));
  const Doubles slope = Doubles(2 * k[0]) + rho * (Doubles(4 * k[1]) + rho * Doubles(6 * k[4]));
  const Doubles along_x = Doubles(2 * k[2]) * y;
  const Doubles along_y = Doubles(2 * k[3]) * x;
  const Doubles xx = radial + x * x * slope + along_x + Doubles(3.0) * along_y;
  const Doubles xy = x * y * slope + Doubles(2 * k[2]) * x + Doubles(2 * k[3]) * y;
  const Doubles yy = radial + y * y * slope + Doubles(3.0) * along_x + along_y;
  return {{xx * inverse_z, xy * inverse_z, negated((xx * x + xy * y) * inverse_z)},
          {xy * inverse_z, yy * inverse_z, negated((xy * x + yy * y) * inverse_z)},
          (p.z > zero) & (xx + yy > zero) & (xx * yy - xy * xy > zero)};
}

// The angle between (r, z), r >= 0, and the z axis, R = sqrt(r^2 + z^2): three times tan(a / 2) = tan a / (1 + sqrt(1 +
// tan^2 a)), then atan t = t - t^3 / 3 + ..., t <= tan(pi / 16), so that the terms left out are below 1e-17 of it.
inline Doubles angle_to_axis(const Doubles& r, const Doubles& z, const Doubles& norm) {
  constexpr double pi = 3.14159265358979324;
  const Doubles one(1.0);
  Doubles t = r / (norm + xsimd::abs(z));
  t = t / (one + xsimd::sqrt(one + t * t));
  t = t / (one + xsimd::sqrt(one + t * t));
  const Doubles square = negated(t * t);
  Doubles sum(1.0 / 23);
  for (int n = 21; n > 0; n -= 2) sum = sum * square + Doubles(1.0 / n);
  const Doubles angle = Doubles(8.0) * t * sum;
  return xsimd::select(z < Doubles(0.0), Doubles(pi) - angle, angle);
}

// m = d (X, Y) / r: along the radius it changes by d' / R, across it by d / r.
inline Image kannala_brandt(const double* k, const Point& p) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles r_squared = p.x * p.x + p.y * p.y;
  const Doubles norm_squared = r_squared + p.z * p.z;
  const Doubles r = xsimd::sqrt(r_squared);
  const Doubles theta = angle_to_axis(r, p.z, xsimd::sqrt(norm_squared));
  const Doubles q = theta * theta;
  const Doubles d = theta * (one + q * (Doubles(k[0]) + q * (Doubles(k[1]) + q * (Doubles(k[2]) + q * Doubles(k[3])))));
  const Doubles slope =
      one + q * (Doubles(3 * k[0]) + q * (Doubles(5 * k[1]) + q * (Doubles(7 * k[2]) + q * Doubles(9 * k[3]))));
  const Mask is_off_axis = r > zero;
  const Doubles inverse_r = xsimd::select(is_off_axis, one / r, zero);
  const Doubles x = p.x * inverse_r;
  const Doubles y = p.y * inverse_r;
  const Doubles across = xsimd::select(is_off_axis, d * inverse_r, one / p.z);
  const Doubles by_z = slope / norm_squared;
  const Doubles along = by_z * p.z - across;
  const Doubles xy = along * (x * y);
  return {{across + along * (x * x), xy, negated(by_z * p.x)},
          {xy, across + along * (y * y), negated(by_z * p.y)},
          (slope > zero) & ((is_off_axis & (d > zero)) | (p.z > zero)) & is_finite(norm_squared)};
}

// m = (X, Y) / D: with dD = g (X dX + Y dY) + h dZ.
inline Image double_sphere(const CameraInput& camera, const Point& p) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles xi(camera.parameters[0]);
  const Doubles alpha(camera.parameters[1]);
  const Doubles beta(1 - camera.parameters[1]);
  const Doubles r_squared = p.x * p.x + p.y * p.y;
  const Doubles norm_squared = r_squared + p.z * p.z;
  const Doubles d1 = xsimd::sqrt(norm_squared);
  const Doubles k = xi * d1 + p.z;
  const Doubles d2 = xsimd::sqrt(r_squared + k * k);
  const Doubles shift = xi / d1;
  const Doubles share = alpha / d2;
  const Doubles inverse = one / (alpha * d2 + beta * k);
  const Doubles square = inverse * inverse;
  const Doubles g = (share * (one + k * shift) + beta * shift) * square;
  const Doubles by_z = (shift * p.z + one) * (share * k + beta) * square;
  const Doubles xy = negated(g * p.x * p.y);
  const Doubles rise = (inverse - g * r_squared) * p.z + by_z * r_squared;  // of |m| with the angle to the axis
  return {{inverse - g * p.x * p.x, xy, negated(by_z * p.x)},
          {xy, inverse - g * p.y * p.y, negated(by_z * p.y)},
          (inverse > zero) & (p.z > Doubles(camera.min_cosine) * d1) & (rise > zero) & is_finite(norm_squared)};
}

inline Image image_of(const CameraInput& camera, const Point& p) {
  switch (camera.model) {
    case Projection::radial_tangential: return radial_tangential(camera.parameters, p);
    case Projection::kannala_brandt: return kannala_brandt(camera.parameters, p);
    case Projection::double_sphere: return double_sphere(camera, p);
    case Projection::pinhole: break;
  }
  return pinhole(p);
}

// d (u, v) / d p_c as rows 0 and 1, and what is wrong with it.
inline Doubles see(const BlockInput& input, const CameraInput& camera, const SeenTile& tile, std::size_t i,
                   const Point& p, Doubles (&rows)[3][3]) {
  const Doubles zero(0.0);
  const Doubles least(input.min_depth);
  Doubles sight(is_seen);
  const auto refuse = [&](const Mask& where, double reason) { sight = xsimd::select(where, Doubles(reason), sight); };
  if (input.jacobians != nullptr) {
    Mask is_given(true);
    for (int e = 0; e < 6; ++e) {
      rows[e / 3][e % 3] = load(tile.jacobian[e], i);
      is_given = is_given & is_finite(rows[e / 3][e % 3]);
    }
    refuse(!is_given, has_no_jacobian);
    refuse(p.z < least, is_too_near);
    refuse(p.z <= zero, is_behind);
    return sight;
  }
  const Image image = image_of(camera, p);
  for (int e = 0; e < 3; ++e) {
    rows[0][e] = Doubles(camera.fx) * image.x[e];
    rows[1][e] = Doubles(camera.fy) * image.y[e];
  }
  const bool ends_in_front = camera.model == Projection::pinhole || camera.model == Projection::radial_tangential;
  const Doubles distance = ends_in_front ? p.z : xsimd::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  refuse(distance < least, is_too_near);
  refuse(!image.exists, is_behind);
  return sight;
}

// H_p^n^-1 [J; 0] by p_c, as the pinhole's map_bias_factor.
inline Doubles see_bias(const BlockInput& input, const Point& p, const Mask& has_third, Doubles (&rows)[3][3]) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles inverse_z = one / p.z;
  rows[0][0] = rows[1][1] = one;
  rows[0][1] = rows[1][0] = zero;
  rows[0][2] = xsimd::select(has_third, zero, negated(p.x * inverse_z));
  rows[1][2] = xsimd::select(has_third, zero, negated(p.y * inverse_z));
  const Doubles near = xsimd::select(p.z < Doubles(input.min_depth), Doubles(is_too_near), Doubles(is_seen));
  return xsimd::select(p.z <= zero, Doubles(is_behind), near);
}

// The third row is that of the depth, times what it takes: of a stereo row the half of (u_right - u), turned against u
// as the pinhole's measurement_factor does.
template <BlockWeighting weighting, ThirdRow third>
inline void add_third(const CameraInput& camera, const Point& p, const Mask& has_third, Doubles (&rows)[3][3]) {
  constexpr double root_half = 0.70710678118654752;
  const Doubles zero(0.0);
  rows[2][0] = rows[2][1] = zero;
  rows[2][2] = xsimd::select(has_third, Doubles(1.0), zero);
  if constexpr (third == ThirdRow::stereo &&
                (weighting == BlockWeighting::measurement || weighting == BlockWeighting::measurement_and_map)) {
    rows[2][2] = xsimd::select(has_third, Doubles(camera.bf * root_half) / (p.z * p.z), zero);
    for (Doubles& entry : rows[0]) entry = xsimd::select(has_third, Doubles(2 * root_half) * entry, entry);
    rows[0][2] = rows[0][2] + rows[2][2];
  }
}

// Rows by p_c to rows by p_b.
inline void turn_to_body(const double* T_cb, Doubles (&rows)[3][3]) {
  for (auto& row : rows) {
    Doubles turned[3];
    for (int j = 0; j < 3; ++j) {
      turned[j] = row[0] * Doubles(T_cb[j]) + row[1] * Doubles(T_cb[4 + j]) + row[2] * Doubles(T_cb[8 + j]);
    }
    for (int j = 0; j < 3; ++j) row[j] = turned[j];
  }
}

// Writes the lanes of `mask` alone.
inline void put(const Doubles& values, const Mask& mask, double* to) {
  xsimd::select(mask, values, Doubles::load_aligned(to)).store_aligned(to);
}

// What one camera sees of the tile's points, p_b.
template <BlockWeighting weighting, ThirdRow third>
inline void see_with(const BlockInput& input, std::size_t number, SeenTile& tile) {
  constexpr bool is_by_map = weighting == BlockWeighting::map_bias || weighting == BlockWeighting::map_bias_world;
  const CameraInput& camera = input.cameras[number];
  const double* const T = camera.T_cb;
  for (std::size_t i = 0; i < tile.count; i += double_lanes) {
    Mask is_its(true);
    if (input.camera_ids != nullptr) is_its = load(tile.camera, i) == Doubles(static_cast<double>(number));
    if (!xsimd::any(is_its)) continue;
    Mask has_third(third != ThirdRow::none);
    if (third != ThirdRow::none && input.has_third != nullptr) has_third = load(tile.has_third, i) > Doubles(0.0);
    Point p = load_point(tile, i);
    if (input.is_rig) p = transform(T, p);
    Doubles rows[3][3];
    const Doubles sight = is_by_map ? see_bias(input, p, has_third, rows) : see(input, camera, tile, i, p, rows);
    add_third<weighting, third>(camera, p, has_third, rows);
    if (input.is_rig) turn_to_body(T, rows);
    put(sight, is_its, tile.sight + i);
    for (int e = 0; e < 9; ++e) put(rows[e / 3][e % 3], is_its, tile.jacobian[e] + i);
    for (int d = 0; weighting == BlockWeighting::map_bias_world && d < 3; ++d) {
      const Doubles along = Doubles(T[d]) * p.x + Doubles(T[4 + d]) * p.y + Doubles(T[8 + d]) * p.z;
      put(along, is_its, tile.ray[d] + i);
    }
  }
}

inline bool is_weighable(const BlockInput& input, const Tile& tile, std::size_t i) {
  if (input.sigmas != nullptr && !(tile.sigma[i] > 0 && tile.sigma[i] <= largest_double)) return false;
  return input.weights == nullptr || tile.weight[i] >= 0;
}

// Takes points to the body's frame, finds their J, and takes out of the tile the matches that have none, or no weight.
template <BlockWeighting weighting, ThirdRow third>
inline void see_and_sift(const BlockInput& input, SeenTile& tile, BlockOutput& output) {
  fill_seen(input, tile);
  std::uint32_t kept[tile_matches];
  std::uint32_t finite[tile_matches / double_lanes];
  for (std::size_t i = 0; i < tile.count; i += double_lanes) {
    const Point p = transform(input.T_cw, load_point(tile, i));
    p.x.store_aligned(tile.point[0] + i);
    p.y.store_aligned(tile.point[1] + i);
    p.z.store_aligned(tile.point[2] + i);
    finite[i / double_lanes] = lanes_of(is_finite(p.x) & is_finite(p.y) & is_finite(p.z));
  }
  for (std::size_t word = 0; word < 4; ++word) {
    for (std::uint64_t rest = tile.cameras[word]; rest != 0; rest &= rest - 1) {
      see_with<weighting, third>(input, 64 * word + static_cast<std::size_t>(__builtin_ctzll(rest)), tile);
    }
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < tile.count; ++i) {
    if ((finite[i / double_lanes] >> (i % double_lanes) & 1U) == 0) continue;
    output.behind_camera += tile.sight[i] == is_behind ? 1 : 0;
    output.too_near += tile.sight[i] == is_too_near ? 1 : 0;
    output.invalid_jacobians += tile.sight[i] == has_no_jacobian ? 1 : 0;
    kept[count] = static_cast<std::uint32_t>(i);
    count += tile.sight[i] == is_seen && is_weighable(input, tile, i) ? 1 : 0;
  }
  if (count == tile.count) return;
  keep_matches(tile, kept, count);
  for (auto& entry : tile.jacobian) keep(entry, kept, count);
  for (auto& coordinate : tile.ray) keep(coordinate, kept, count);
}

// The rows of a block over their deviations.
template <ThirdRow third, int Rows>
inline Mask weigh_rows(const BlockInput& input, const Tile& tile, std::size_t i, const Mask& has_third,
                       Doubles (&rows)[Rows][3]) {
  const Doubles zero(0.0);
  Mask is_definite(true);
  if (input.sigmas != nullptr) {
    const Doubles sigma = load(tile.sigma, i);
    is_definite = sigma * sigma > zero;
    const Doubles weight = Doubles(1.0) / sigma;
    for (int row = 0; row < (third == ThirdRow::stereo ? Rows : 2); ++row) {
      for (Doubles& entry : rows[row]) entry *= weight;
    }
  }
  if constexpr (third == ThirdRow::depth) {
    is_definite = is_definite & ((Doubles(input.depth_sigma * input.depth_sigma) > zero) | !has_third);
    for (Doubles& entry : rows[2]) entry *= Doubles(1 / input.depth_sigma);
  }
  return is_definite;
}

// J Sigma_p J^T, and the bound of what is rounded in it: |entry (a, b)| to 3u norm[a] norm[b] sqrt(square), square =
// |Sigma_p|^2.
template <int Rows>
struct Mapped {
  Doubles entries[Rows][Rows];  // the lower triangle
  Doubles norms[Rows];
  Doubles square;
};

template <int Rows>
inline Mapped<Rows> map_rows(const BlockInput& input, const Tile& tile, std::size_t i, const Doubles (&rows)[Rows][3]) {
  constexpr int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};  // of Sigma_p
  const auto dot = [](const Doubles* a, const Doubles* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  Mapped<Rows> mapped;
  Doubles world[Rows][3];    // J R
  Doubles product[Rows][3];  // J R Sigma_p
  const bool is_round = input.map_covariances == nullptr;
  const Doubles variance(input.map_sigma * input.map_sigma);
  Doubles s[6];
  for (int e = 0; e < 6; ++e) s[e] = is_round ? variance : load(tile.map_covariance[e], i);
  for (int a = 0; a < Rows; ++a) {
    for (int j = 0; j < 3; ++j) {
      const double* const r = input.T_cw + j;
      world[a][j] =
          is_round ? rows[a][j] : rows[a][0] * Doubles(r[0]) + rows[a][1] * Doubles(r[4]) + rows[a][2] * Doubles(r[8]);
    }
    for (int j = 0; j < 3; ++j) {
      product[a][j] = is_round ? world[a][j] * variance
                               : world[a][0] * s[at[0][j]] + world[a][1] * s[at[1][j]] + world[a][2] * s[at[2][j]];
    }
    mapped.norms[a] = xsimd::abs(world[a][0]) + xsimd::abs(world[a][1]) + xsimd::abs(world[a][2]);
    for (int b = 0; b <= a; ++b) mapped.entries[a][b] = dot(product[a], world[b]);
  }
  mapped.square = is_round ? Doubles(3.0) * variance * variance : frobenius_squared(s);
  return mapped;
}

// C^-1 J with C C^T = Sigma_z + J Sigma_p J^T, C lower triangular. Returns where that is positive definite, and keeps
// its digits.
template <ThirdRow third, int Rows>
inline Mask whiten_rows(const BlockInput& input, const Tile& tile, std::size_t i, const Mask& has_third,
                        Doubles (&rows)[Rows][3]) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles sigma = input.sigmas == nullptr ? one : load(tile.sigma, i);
  const Mapped<Rows> mapped = map_rows(input, tile, i, rows);
  Mask is_definite = sigma * sigma > zero;
  Doubles c[Rows][Rows];
  Doubles inverse[Rows];  // of the diagonal of C
  Doubles norms = zero;   // | |C^-1| norms |^2
  Doubles of_row[Rows];   // |C^-1| norms
  Doubles inverses[Rows][Rows];
  for (int a = 0; a < Rows; ++a) {
    for (int b = 0; b < a; ++b) {
      Doubles rest = mapped.entries[a][b];
      for (int k = 0; k < b; ++k) rest -= c[a][k] * c[b][k];
      c[a][b] = rest * inverse[b];
    }
    Doubles variance = sigma * sigma;
    if (third == ThirdRow::depth && a == 2) {
      variance = xsimd::select(has_third, Doubles(input.depth_sigma * input.depth_sigma), one);
      is_definite = is_definite & (variance > zero);
    }
    Doubles pivot = mapped.entries[a][a] + variance;
    for (int k = 0; k < a; ++k) pivot -= c[a][k] * c[a][k];
    is_definite = is_definite & is_positive(pivot);
    inverse[a] = one / xsimd::sqrt(pivot);
    inverses[a][a] = inverse[a];
    of_row[a] = inverse[a] * mapped.norms[a];
    for (int b = 0; b < a; ++b) {
      Doubles sum = zero;
      for (int k = b; k < a; ++k) sum += c[a][k] * inverses[k][b];
      inverses[a][b] = negated(sum * inverse[a]);
      of_row[a] += xsimd::abs(inverses[a][b]) * mapped.norms[b];
    }
    norms += of_row[a] * of_row[a];
  }
  for (int a = Rows - 1; a >= 0; --a) {
    for (int j = 0; j < 3; ++j) {
      Doubles sum = inverses[a][a] * rows[a][j];
      for (int b = 0; b < a; ++b) sum += inverses[a][b] * rows[b][j];
      rows[a][j] = sum;
    }
  }
  return is_definite & keeps_digits(mapped.square, norms);
}

// Rotates rows a and b, so that b has a zero in `column`.
template <int Rows>
inline void turn(int a, int b, int column, Doubles (&rows)[Rows][3]) {
  const Doubles zero(0.0);
  const Doubles norm = xsimd::sqrt(rows[a][column] * rows[a][column] + rows[b][column] * rows[b][column]);
  const Mask is_turned = norm > zero;
  const Doubles cosine = xsimd::select(is_turned, rows[a][column] / norm, Doubles(1.0));
  const Doubles sine = xsimd::select(is_turned, rows[b][column] / norm, zero);
  rows[a][column] = norm;
  for (int j = column + 1; j < 3; ++j) {
    const Doubles kept = rows[a][j];
    rows[a][j] = cosine * kept + sine * rows[b][j];
    rows[b][j] = cosine * rows[b][j] - sine * kept;
  }
}

// An upper triangular A = Q rows.
template <int Rows>
inline Factor<Rows> triangle_of(Doubles (&rows)[Rows][3]) {
  turn(0, 1, 0, rows);
  if constexpr (Rows == 3) {
    turn(0, 2, 0, rows);
    turn(1, 2, 1, rows);
  }
  Factor<Rows> factor;
  for (int a = 0; a < Rows; ++a) {
    for (int j = a; j < 3; ++j) factor.a[a][j] = rows[a][j];
  }
  return factor;
}

// The factor of a block by p_b; returns where there is one.
template <BlockWeighting weighting, ThirdRow third, int Rows>
inline Mask seen_factor(const BlockInput& input, const SeenTile& tile, std::size_t i, const Mask& has_third,
                        Factor<Rows>& factor) {
  Doubles rows[Rows][3];
  for (int e = 0; e < 3 * Rows; ++e) rows[e / 3][e % 3] = load(tile.jacobian[e], i);
  Mask valid(true);
  if constexpr (weighting == BlockWeighting::measurement) {
    valid = weigh_rows<third>(input, tile, i, has_third, rows);
  } else if constexpr (weighting == BlockWeighting::measurement_and_map) {
    valid = whiten_rows<third>(input, tile, i, has_third, rows);
  }
  factor = triangle_of(rows);
  return valid;
}

}  // namespace
