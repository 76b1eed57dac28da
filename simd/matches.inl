// SPDX-License-Identifier: MIT
// Matches as packs, one per lane: their input, and their points in the camera frame. From here to blocks
// (jacobians.inl, factors_by_jacobian.inl, factors_along_ray.inl, blocks.inl) everything is float64 by + - * / and sqrt
// in one fixed order: the same bits on every instruction set.

namespace {

using maxlogdet::DepthCue;
using maxlogdet::Weighting;
using maxlogdet::simd::BlockInput;
using maxlogdet::simd::BlockOutput;
using maxlogdet::simd::is_by_map_bias;
using maxlogdet::simd::is_finite;
using maxlogdet::simd::is_positive;
using maxlogdet::simd::negated;
using Mask = xsimd::batch_bool<double>;
using Point = maxlogdet::simd::PointOf<Doubles>;

// What is known of a match, a double each. Only blocks by the rows of J have what is from `camera` on.
namespace value {
constexpr std::size_t point = 0;  // 3, in the world, then in the camera's or body's frame
constexpr std::size_t sigma = 3;
constexpr std::size_t has_third = 4;
constexpr std::size_t map_covariance = 5;  // 6, the upper triangle, by rows
constexpr std::size_t camera = 11;         // its number
constexpr std::size_t refusal = 12;        // why there is no J
constexpr std::size_t jacobian = 13;       // 9, J by p_b, 3 x 3
constexpr std::size_t ray = 22;            // 3, from the camera to the point, in the body's axes, for map_bias_world
constexpr std::size_t count = 25;
}  // namespace value

// Some matches, an array per value, so that packs load whole vectors, and filled well before: a vector load right after
// the scalar stores it reads from would stall. The last match is repeated up to a whole pack, which changes no maximum.
constexpr std::size_t batch_size = 64;
static_assert(batch_size % double_lanes == 0, "a batch holds whole packs");

struct Batch {
  std::size_t count;
  std::uint32_t number[batch_size];  // of the match
  alignas(64) double values[value::count][batch_size];
};

inline Doubles load(const Batch& batch, std::size_t value, std::size_t i) {
  return Doubles::load_aligned(batch.values[value] + i);
}

inline void store(const Doubles& pack, std::size_t value, std::size_t i, Batch& batch) {
  pack.store_aligned(batch.values[value] + i);
}

inline Point load_point(const Batch& batch, std::size_t value, std::size_t i) {
  return {load(batch, value, i), load(batch, value + 1, i), load(batch, value + 2, i)};
}

inline void repeat_last(Batch& batch, std::size_t value) {
  double* const values = batch.values[value];
  for (std::size_t i = batch.count; i % double_lanes != 0; ++i) values[i] = values[batch.count - 1];
}

// Lists usable matches from `next` on until the batch is full; returns the first one not looked at.
inline std::size_t list_usable(const BlockInput& input, std::size_t next, Batch& batch, BlockOutput& output) {
  batch.count = 0;
  const std::size_t first = next;
  if (input.usable == nullptr && input.camera_ids == nullptr) {
    for (; next < input.size && batch.count < batch_size; ++next) {
      batch.number[batch.count++] = static_cast<std::uint32_t>(next);
    }
    return next;
  }
  for (; next < input.size && batch.count < batch_size; ++next) {
    batch.number[batch.count] = static_cast<std::uint32_t>(next);
    const bool is_usable = input.usable == nullptr || input.usable[next] != 0;
    const bool has_camera = input.camera_ids == nullptr || input.camera_ids[next] < input.camera_count;
    batch.count += is_usable && has_camera ? 1 : 0;
  }
  output.invalid[maxlogdet::simd::unusable] += next - first - batch.count;
  return next;
}

// Reads the `entries` of each match, which has `stride` of them in `source`; no-op without a source.
template <std::size_t stride, std::size_t n, class T>
inline void fill(Batch& batch, std::size_t value, const T* source, const std::size_t (&entries)[n]) {
  if (source == nullptr) return;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const T* const from = source + stride * batch.number[i];
    for (std::size_t e = 0; e < n; ++e) batch.values[value + e][i] = static_cast<double>(from[entries[e]]);
  }
  for (std::size_t e = 0; e < n; ++e) repeat_last(batch, value + e);
}

template <class Scalar>
inline void fill_points(const BlockInput& input, Batch& batch) {
  for (std::size_t i = 0; i < batch.count; ++i) {
    Scalar point[3];
    std::memcpy(point, input.points + input.point_stride * batch.number[i], sizeof point);
    for (std::size_t d = 0; d < 3; ++d) batch.values[value::point + d][i] = static_cast<double>(point[d]);
  }
  for (std::size_t d = 0; d < 3; ++d) repeat_last(batch, value::point + d);
}

template <Weighting weighting, DepthCue third, bool by_jacobian>
inline void fill(const BlockInput& input, Batch& batch) {
  input.are_points_float ? fill_points<float>(input, batch) : fill_points<double>(input, batch);
  fill<1>(batch, value::sigma, input.sigmas, {0});
  if (third != DepthCue::none) fill<1>(batch, value::has_third, input.has_third, {0});
  if (weighting == Weighting::measurement_and_map) {
    fill<9>(batch, value::map_covariance, input.map_covariances, maxlogdet::simd::upper_triangle);
  }
  if (by_jacobian) fill<1>(batch, value::camera, input.camera_ids, {0});
}

// Which matches of a pack have a third measurement.
template <DepthCue third>
inline Mask third_of(const BlockInput& input, const Batch& batch, std::size_t i) {
  if (third == DepthCue::none || input.has_third == nullptr) return Mask(third != DepthCue::none);
  return load(batch, value::has_third, i) > Doubles(0.0);
}

[[gnu::always_inline]] inline maxlogdet::simd::NoiseOf<Doubles> noise_of(const BlockInput& input, const Batch& batch,
                                                                         std::size_t i, const Mask& has_third) {
  const Doubles sigma = input.sigmas == nullptr ? Doubles(1.0) : load(batch, value::sigma, i);
  return maxlogdet::simd::noise_of(input, sigma, has_third, [&](int e) {
    return load(batch, value::map_covariance + static_cast<std::size_t>(e), i);
  });
}

[[gnu::always_inline]] inline Point transform(const double* T, const Point& from) {
  Doubles p[3];
  for (int row = 0; row < 3; ++row) {
    const double* const r = T + 4 * row;
    p[row] = Doubles(r[0]) * from.x + Doubles(r[1]) * from.y + Doubles(r[2]) * from.z + Doubles(r[3]);
  }
  return {p[0], p[1], p[2]};
}

// Transforms points of a pack from the world to the frame of the camera or body.
[[gnu::always_inline]] inline Point transform(const BlockInput& input, Batch& batch, std::size_t i) {
  const Point p = transform(input.T_bw, load_point(batch, value::point, i));
  store(p.x, value::point, i, batch);
  store(p.y, value::point + 1, i, batch);
  store(p.z, value::point + 2, i, batch);
  return p;
}

// Why matches have no J: an InvalidMatch, or one of these.
constexpr double is_accepted = -1;
constexpr double is_not_finite = -2;

inline void refuse(const Mask& where, double reason, Doubles& refusal) {
  refusal = xsimd::select(where, Doubles(reason), refusal);
}

inline void refuse_near(const BlockInput& input, const Doubles& depth, const Mask& is_behind, Doubles& refusal) {
  refuse(depth < Doubles(input.min_depth), maxlogdet::simd::too_near, refusal);
  refuse(is_behind, maxlogdet::simd::behind_camera, refusal);
}

inline std::uint32_t lanes_of(const Mask& mask) {
  alignas(sizeof(Doubles)) double ones[double_lanes];
  xsimd::select(mask, Doubles(1.0), Doubles(0.0)).store_aligned(ones);
  std::uint32_t lanes = 0;
  for (std::size_t lane = 0; lane < double_lanes; ++lane) lanes |= ones[lane] != 0 ? 1U << lane : 0U;
  return lanes;
}

inline void keep(Batch& batch, std::size_t values, const std::uint32_t* kept, std::size_t count) {
  std::size_t first = 0;  // before it, all stay in their place
  while (first < count && kept[first] == first) ++first;
  batch.count = count;
  for (std::size_t i = first; i < count; ++i) batch.number[i] = batch.number[kept[i]];
  for (std::size_t value = 0; value < values; ++value) {
    for (std::size_t i = first; i < count; ++i) batch.values[value][i] = batch.values[value][kept[i]];
    if (count > 0) repeat_last(batch, value);
  }
}

// Removes from the batch matches that have no J, or no weight. A pinhole's points are transformed here: they need no
// look of their own.
template <bool by_jacobian>
[[gnu::always_inline]] inline void filter(const BlockInput& input, Batch& batch, BlockOutput& output) {
  std::uint32_t kept[batch_size];
  std::size_t count = 0;
  for (std::size_t i = 0; i < batch.count; i += double_lanes) {
    const std::size_t used = batch.count - i < double_lanes ? batch.count - i : double_lanes;
    Mask valid(true);
    Point p;
    if constexpr (by_jacobian) {
      valid = load(batch, value::refusal, i) == Doubles(is_accepted);
    } else {
      p = transform(input, batch, i);
      valid = is_positive(p.z) & (p.z >= Doubles(input.min_depth)) & is_finite(p.x) & is_finite(p.y);
    }
    if (input.sigmas != nullptr) valid = valid & is_positive(load(batch, value::sigma, i));
    if (xsimd::all(valid)) {
      for (std::size_t lane = 0; lane < used; ++lane) kept[count++] = static_cast<std::uint32_t>(i + lane);
      continue;
    }
    if constexpr (!by_jacobian) {
      Doubles refusal(is_accepted);
      refuse_near(input, p.z, p.z <= Doubles(0.0), refusal);
      store(refusal, value::refusal, i, batch);
    }
    const std::uint32_t valid_lanes = lanes_of(valid);
    for (std::uint32_t lane = 0; lane < used; ++lane) {
      kept[count] = static_cast<std::uint32_t>(i) + lane;
      count += valid_lanes >> lane & 1U;
      const double reason = batch.values[value::refusal][i + lane];
      if (reason >= 0) ++output.invalid[static_cast<std::size_t>(reason)];
    }
  }
  if (count < batch.count) keep(batch, by_jacobian ? value::count : value::camera, kept, count);
}

}  // namespace
