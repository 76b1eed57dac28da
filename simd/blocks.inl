// SPDX-License-Identifier: MIT
// Blocks of matches, rounded to float32, in the planes of a store. A block is A [ I | -[p]x ], p in the frame of the
// body, with an upper triangular A: its rows are those of the measurements after a rotation among them, which changes
// no gain, and keeps them from being nearly parallel, as u and u_right are.

namespace maxlogdet::simd {
namespace {

// What is known of a match, a double each.
namespace value {
constexpr std::size_t point = 0;  // 3, in the world; NaN if the match is not usable
constexpr std::size_t sigma = 3;
constexpr std::size_t third = 4;           // u_right or the depth
constexpr std::size_t camera = 5;          // its number
constexpr std::size_t map_covariance = 6;  // 6, the upper triangle, by rows
constexpr std::size_t count = 12;
}  // namespace value

// Consecutive matches, an array per value, so that packs load whole vectors, and filled well before: a vector load
// right after the scalar stores that it reads from would stall.
constexpr std::size_t batch_size = 64;
static_assert(batch_size % double_lanes == 0 && double_lanes <= most_double_lanes, "a batch holds whole packs");

struct Batch {
  std::size_t first, count;
  alignas(64) double values[value::count][batch_size];

  Doubles load(std::size_t value, std::size_t i) const { return Doubles::load_aligned(values[value] + i); }
  Point point(std::size_t i) const {
    return {load(value::point, i), load(value::point + 1, i), load(value::point + 2, i)};
  }
};

// Reads matches from batch.first on; lanes beyond the last match are not usable.
template <DepthCue third, bool by_map>
inline void read_matches(const BlockInput& input, Batch& batch, BlockOutput& output) {
  for (std::size_t i = 0; i < batch.count; ++i) {
    const FeatureMatch& match = input.matches[batch.first + i];
    const bool is_usable =
        (input.usable == nullptr || input.usable[batch.first + i] != 0) && match.camera_id < input.camera_count;
    output.unusable += is_usable ? 0 : 1;
    const double x = is_usable ? match.point[0] : std::numeric_limits<double>::quiet_NaN();
    batch.values[value::point][i] = x;
    batch.values[value::point + 1][i] = match.point[1];
    batch.values[value::point + 2][i] = match.point[2];
    batch.values[value::sigma][i] = match.sigma;
    if (third == DepthCue::stereo) batch.values[value::third][i] = match.u_right;
    if (third == DepthCue::depth) batch.values[value::third][i] = match.depth;
    batch.values[value::camera][i] = static_cast<double>(match.camera_id);
    for (std::size_t e = 0; by_map && e < 6; ++e)
      batch.values[value::map_covariance + e][i] = map_covariance_of(match, input.map_sigma, e);
  }
  for (std::size_t i = batch.count; i % double_lanes != 0; ++i) {
    for (auto& values : batch.values) values[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

template <DepthCue third, bool by_map>
inline Noise noise_of(const BlockInput& input, const Batch& batch, std::size_t i) {
  Noise noise;
  noise.sigma = batch.load(value::sigma, i);
  noise.of_depth = Doubles(input.depth_sigma);
  noise.has_third = Mask(false);
  if constexpr (third == DepthCue::stereo) {
    const Doubles u_right = batch.load(value::third, i);
    noise.has_third = (u_right >= Doubles(0.0)) & is_finite(u_right);
  } else if constexpr (third == DepthCue::depth) {
    noise.has_third = is_positive(batch.load(value::third, i));
  }
  for (std::size_t e = 0; by_map && e < 6; ++e) noise.map[e] = batch.load(value::map_covariance + e, i);
  return noise;
}

// Rotates rows a and b, so that b has a zero in `column`, and a what is not negative.
inline void rotate_rows(int column, Doubles (&a)[3], Doubles (&b)[3]) {
  const Doubles zero(0.0);
  const Doubles norm = xsimd::sqrt(a[column] * a[column] + b[column] * b[column]);
  const Mask is_nonzero = norm > zero;
  const Doubles cosine = xsimd::select(is_nonzero, a[column] / norm, Doubles(1.0));
  const Doubles sine = xsimd::select(is_nonzero, b[column] / norm, zero);
  a[column] = norm;
  for (int j = column + 1; j < 3; ++j) {
    const Doubles kept = a[j];
    a[j] = cosine * kept + sine * b[j];
    b[j] = cosine * b[j] - sine * kept;
  }
}

// A = Q rows, Q a rotation.
template <int Rows>
inline void make_triangular(Doubles (&rows)[Rows][3]) {
  rotate_rows(0, rows[0], rows[1]);
  if constexpr (Rows == 3) {
    rotate_rows(0, rows[0], rows[2]);
    rotate_rows(1, rows[1], rows[2]);
  }
}

// What a camera makes of a pack of matches.
template <int Rows>
struct SeenPack {
  Doubles a[Rows][3];           // an upper triangular A; what is below its diagonal is not read
  Mask has_image, is_definite;  // no variance has underflowed to zero, nor has a covariance left no digits
};

// A of any camera on the body, p_b in the body's frame.
template <DepthCue third, bool by_map>
[[gnu::always_inline]] inline void see_by_jacobian(const BlockInput& input, const CameraInput& camera, const Point& p_b,
                                                   const Noise& noise, SeenPack<rows_with(third)>& seen) {
  constexpr int row_count = rows_with(third);
  Point p_c;
  Doubles(&rows)[row_count][3] = seen.a;
  seen.has_image = linearise<third>(camera, p_b, noise.has_third, p_c, rows).exists;
  if constexpr (by_map) {
    Doubles whitening[row_count][row_count];
    seen.is_definite = whiten<third>(noise, covariance_of<third>(input.T_bw, noise, rows), whitening);
    multiply_by_upper(whitening, rows);
  } else {
    seen.is_definite = has_variances<third>(noise);
    const Doubles weight = Doubles(1.0) / noise.sigma;
    for (int row = 0; row < row_count; ++row) {
      const Doubles of_row = weight_of_row<third>(row, weight, input.depth_sigma);
      for (Doubles& entry : rows[row]) entry *= of_row;
    }
  }
  if (!is_plain(camera)) make_triangular(rows);  // a pinhole's J is triangular
}

// A pack of matches from lane i of the batch on, each as its camera sees it.
template <DepthCue third, bool by_map>
[[gnu::always_inline]] inline void see(const BlockInput& input, const Batch& batch, std::size_t i, const Point& p,
                                       const Noise& noise, SeenPack<rows_with(third)>& seen) {
  if (input.camera_count == 1) {
    see_by_jacobian<third, by_map>(input, input.cameras[0], p, noise, seen);
  } else {
    seen.has_image = seen.is_definite = Mask(false);
    for (auto& row : seen.a) row[0] = row[1] = row[2] = Doubles(0.0);
    for (std::size_t number = 0; number < input.camera_count; ++number) {
      const Mask is_its = batch.load(value::camera, i) == Doubles(static_cast<double>(number));
      if (!xsimd::any(is_its)) continue;
      SeenPack<rows_with(third)> by_this;
      see_by_jacobian<third, by_map>(input, input.cameras[number], p, noise, by_this);
      seen.has_image = seen.has_image | (is_its & by_this.has_image);
      seen.is_definite = seen.is_definite | (is_its & by_this.is_definite);
      for (int row = 0; row < rows_with(third); ++row) {
        for (int j = row; j < 3; ++j) {
          seen.a[row][j] = xsimd::select(is_its, by_this.a[row][j], seen.a[row][j]);
        }
      }
    }
  }
}

// H = A [ I | -[p]x ].
template <int Rows>
inline void multiply_by_point_jacobian(const Doubles (&a)[Rows][3], const Point& p, Doubles (&h)[Rows][dimension]) {
  for (int row = 0; row < Rows; ++row) {
    for (int j = 0; j < 3; ++j) h[row][j] = j < row ? Doubles(0.0) : a[row][j];
  }
  cross(p, a[0][0], a[0][1], a[0][2], h[0] + 3);
  cross(p, Zero(), a[1][1], a[1][2], h[1] + 3);
  if constexpr (Rows == 3) cross(p, Zero(), Zero(), a[2][2], h[2] + 3);
}

// Where float32 holds every entry.
template <int Rows>
inline Mask is_held(const Doubles (&h)[Rows][dimension]) {
  const Doubles beyond(0x1.ffffffp127);  // 2^128 - 2^103: float32 rounds it to infinity
  Mask are_all(true);
  for (const auto& row : h) {
    for (const Doubles& entry : row) are_all = are_all & (xsimd::abs(entry) < beyond);
  }
  return are_all;
}

// The largest magnitudes so far: of the columns, of those of |A| [ I | |[p]x| ] from the fourth on, and of p.
struct Largest {
  Doubles columns[dimension], factored[3], point;

  Largest() : point(0.0) {
    for (Doubles& column : columns) column = Doubles(0.0);
    for (Doubles& column : factored) column = Doubles(0.0);
  }
  template <int Rows>
  void take(const Doubles (&h)[Rows][dimension], const Point& p) {
    for (int column = 0; column < dimension; ++column) {
      for (const auto& row : h) columns[column] = xsimd::max(columns[column], xsimd::abs(row[column]));
    }
    if constexpr (Rows == 3) {
      const Doubles x = xsimd::abs(p.x), y = xsimd::abs(p.y), z = xsimd::abs(p.z);
      point = xsimd::max(point, xsimd::max(x, xsimd::max(y, z)));
      for (const auto& row : h) {
        const Doubles a = xsimd::abs(row[0]), b = xsimd::abs(row[1]), c = xsimd::abs(row[2]);
        factored[0] = xsimd::max(factored[0], b * z + c * y);
        factored[1] = xsimd::max(factored[1], a * z + c * x);
        factored[2] = xsimd::max(factored[2], a * y + b * x);
      }
    }
  }
};

inline double largest_lane(const Doubles& values) {
  alignas(sizeof(Doubles)) double lanes[double_lanes];
  values.store_aligned(lanes);
  double largest = lanes[0];
  for (const double lane : lanes) largest = lane > largest ? lane : largest;
  return largest;
}

// Of entries as float32 holds them: they are off by 2^-24, or by 2^-150 if they are denormal.
template <int Rows>
inline void summarise(const Largest& largest, BlockOutput& output) {
  constexpr double largest_held = 1e15, room = 1 + sum_room;
  const double point = largest_lane(largest.point);
  bool is_held = Rows == 3 && point <= largest_held;
  for (int column = 0; column < dimension; ++column) {
    output.column_max[column] = static_cast<double>(static_cast<float>(largest_lane(largest.columns[column])));
    if (column < 3) {
      output.factored_max[column] = room * output.column_max[column];
      is_held = is_held && output.column_max[column] <= largest_held;
    } else {
      output.factored_max[column] = room * (largest_lane(largest.factored[column - 3]) + 0x1p-148 * point);
    }
  }
  if (is_held) return;
  for (double& column : output.factored_max) column = std::numeric_limits<double>::infinity();
}

inline std::size_t count_of(const Mask& mask) { return static_cast<std::size_t>(__builtin_popcount(lane_mask(mask))); }

// Counts the matches of a pack, and why the others have no block.
inline void report(const Mask& is_finite, const Mask& is_there, const Mask& has_image, const Mask& is_definite,
                   const Mask& is_valid, unsigned char* validity, std::size_t used, BlockOutput& output) {
  if (used == double_lanes && xsimd::all(is_valid)) {
    std::memset(validity, 1, double_lanes);
    output.valid += double_lanes;
    return;
  }
  const std::uint32_t valid_lanes = lane_mask(is_valid);
  for (std::size_t lane = 0; lane < used; ++lane) validity[lane] = valid_lanes >> lane & 1U;
  output.valid += static_cast<std::size_t>(__builtin_popcount(valid_lanes));
  output.behind_camera += count_of(is_finite & !has_image);
  output.invalid_covariances += count_of(is_there & has_image & !is_definite);
}

// Makes a pack of blocks, of lanes [i, i + double_lanes) of the batch.
template <DepthCue third, bool by_map>
[[gnu::always_inline]] inline void build_pack(const BlockInput& input, const Batch& batch, std::size_t i,
                                              Largest& largest, Mask& has_three_rows, BlockOutput& output) {
  constexpr int row_count = rows_with(third);
  const Noise noise = noise_of<third, by_map>(input, batch, i);
  const Point p = transform(input.T_bw, batch.point(i));
  SeenPack<row_count> seen;
  see<third, by_map>(input, batch, i, p, noise, seen);
  Doubles h[row_count][dimension];
  multiply_by_point_jacobian(seen.a, p, h);
  const Mask is_placed = is_finite(p);
  const Mask is_there = is_placed & is_positive(noise.sigma);
  const Mask is_valid = is_there & seen.has_image & seen.is_definite & is_held(h);
  const std::size_t at = batch.first + i;
  const std::size_t used = batch.count - i < double_lanes ? batch.count - i : double_lanes;
  report(is_placed, is_there, seen.has_image, seen.is_definite, is_valid, output.validity + at, used, output);
  has_three_rows = has_three_rows | (is_valid & noise.has_third);

  const auto put = [&](Doubles& entry, std::size_t plane) {
    entry = xsimd::select(is_valid, entry, Doubles(0.0));
    store_narrow(entry, output.planes + plane * output.stride + at);
  };
  std::size_t plane = 0;
  for (auto& row : h) {
    for (Doubles& entry : row) put(entry, plane++);
  }
  Point of_block = p;
  if constexpr (row_count == 3) {
    put(of_block.x, point_plane);
    put(of_block.y, point_plane + 1);
    put(of_block.z, point_plane + 2);
  }
  largest.take(h, of_block);
}

template <DepthCue third, bool by_map>
void build_blocks(const BlockInput& input, BlockOutput& output) {
  Batch batch;
  Largest largest;
  Mask has_three_rows(false);
  for (batch.first = 0; batch.first < input.size; batch.first += batch_size) {
    batch.count = input.size - batch.first < batch_size ? input.size - batch.first : batch_size;
    read_matches<third, by_map>(input, batch, output);
    for (std::size_t i = 0; i < batch.count; i += double_lanes) {
      build_pack<third, by_map>(input, batch, i, largest, has_three_rows, output);
    }
  }
  output.has_three_rows = xsimd::any(has_three_rows);
  summarise<rows_with(third)>(largest, output);
}

template <DepthCue third>
void build_blocks(const BlockInput& input, BlockOutput& output) {
  input.by_map ? build_blocks<third, true>(input, output) : build_blocks<third, false>(input, output);
}

void build_blocks(const BlockInput& input, BlockOutput& output) {
  switch (input.third) {
    case DepthCue::none: return build_blocks<DepthCue::none>(input, output);
    case DepthCue::stereo: return build_blocks<DepthCue::stereo>(input, output);
    case DepthCue::depth: return build_blocks<DepthCue::depth>(input, output);
  }
}

}  // namespace
}  // namespace maxlogdet::simd
