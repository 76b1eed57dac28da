// SPDX-License-Identifier: MIT
// Matches as packs, one per lane: their input, and their points in the camera frame. From here to blocks (cameras.inl,
// seen_factors.inl, block_factors.inl, blocks.inl) everything is float64 by + - * / and sqrt in one fixed order: the
// same bits on every instruction set.

namespace {

using maxlogdet::simd::BlockInput;
using maxlogdet::simd::BlockOutput;
using maxlogdet::simd::BlockWeighting;
using maxlogdet::simd::is_finite;
using maxlogdet::simd::is_positive;
using maxlogdet::simd::negated;
using maxlogdet::simd::root_half;
using maxlogdet::simd::ThirdRow;
using maxlogdet::simd::upper_triangle;
using Mask = xsimd::batch_bool<double>;

constexpr double largest_double = 1.7976931348623157e308;

// The input of some matches, an array per value, so that packs load whole vectors, and filled well before: a vector
// load right after the scalar stores it reads from would stall. The last match is repeated up to a whole pack, which
// changes no maximum.
constexpr std::size_t batch_size = 64;
static_assert(batch_size % double_lanes == 0, "a batch holds whole packs");

struct Batch {
  std::size_t count;
  std::uint32_t number[batch_size];         // of the match
  alignas(64) double point[3][batch_size];  // in the world, then in the camera frame
  alignas(64) double sigma[batch_size];
  alignas(64) double weight[batch_size];
  alignas(64) double has_third[batch_size];
  alignas(64) double map_covariance[6][batch_size];  // upper triangle, by rows
};

inline Doubles load(const double (&values)[batch_size], std::size_t i) { return Doubles::load_aligned(values + i); }

inline void repeat_last(double (&values)[batch_size], std::size_t count) {
  for (std::size_t i = count; i % double_lanes != 0; ++i) values[i] = values[count - 1];
}

// Lists usable matches from `next` on until the batch is full; returns the first one not looked at.
inline std::size_t list_usable(const BlockInput& input, std::size_t next, Batch& batch, BlockOutput& output) {
  batch.count = 0;
  const std::size_t first = next;
  if (input.usable == nullptr) {
    for (; next < input.size && batch.count < batch_size; ++next) {
      batch.number[batch.count++] = static_cast<std::uint32_t>(next);
    }
    return next;
  }
  for (; next < input.size && batch.count < batch_size; ++next) {
    batch.number[batch.count] = static_cast<std::uint32_t>(next);
    batch.count += input.usable[next] != 0 ? 1 : 0;
  }
  output.unusable += next - first - batch.count;
  return next;
}

template <std::size_t entries, class T>
inline void fill(double (&values)[batch_size], const T* source, std::size_t entry, const Batch& batch) {
  for (std::size_t i = 0; i < batch.count; ++i)
    values[i] = static_cast<double>(source[entries * batch.number[i] + entry]);
  repeat_last(values, batch.count);
}

template <class Scalar>
inline void fill_points(const BlockInput& input, Batch& batch) {
  for (std::size_t i = 0; i < batch.count; ++i) {
    Scalar point[3];
    std::memcpy(point, input.points + input.point_stride * batch.number[i], sizeof point);
    for (std::size_t d = 0; d < 3; ++d) batch.point[d][i] = static_cast<double>(point[d]);
  }
  for (auto& coordinate : batch.point) repeat_last(coordinate, batch.count);
}

template <BlockWeighting weighting, ThirdRow third>
inline void fill(const BlockInput& input, Batch& batch) {
  input.are_points_float ? fill_points<float>(input, batch) : fill_points<double>(input, batch);
  if (input.sigmas != nullptr) fill<1>(batch.sigma, input.sigmas, 0, batch);
  if (input.weights != nullptr) fill<1>(batch.weight, input.weights, 0, batch);
  if (third != ThirdRow::none && input.has_third != nullptr) fill<1>(batch.has_third, input.has_third, 0, batch);
  if (weighting == BlockWeighting::measurement_and_map && input.map_covariances != nullptr) {
    for (std::size_t i = 0; i < batch.count; ++i) {
      const double* const covariance = input.map_covariances + std::size_t{9} * batch.number[i];
      for (std::size_t e = 0; e < 6; ++e) batch.map_covariance[e][i] = covariance[upper_triangle[e]];
    }
    for (auto& entry : batch.map_covariance) repeat_last(entry, batch.count);
  }
}

using Point = maxlogdet::simd::PointOf<Doubles>;

inline Point load_point(const Batch& batch, std::size_t i) {
  return {load(batch.point[0], i), load(batch.point[1], i), load(batch.point[2], i)};
}

[[gnu::always_inline]] inline Point transform(const double* T_cw, const Point& world) {
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

inline void keep_matches(Batch& batch, const std::uint32_t* kept, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) batch.number[i] = batch.number[kept[i]];
  for (auto& coordinate : batch.point) keep(coordinate, kept, count);
  keep(batch.sigma, kept, count);
  keep(batch.weight, kept, count);
  keep(batch.has_third, kept, count);
  for (auto& entry : batch.map_covariance) keep(entry, kept, count);
  batch.count = count;
}

// Transforms points to the camera frame, and removes from the batch matches that have no Jacobian there, or no weight.
[[gnu::always_inline]] inline void transform_and_filter(const BlockInput& input, Batch& batch, BlockOutput& output) {
  std::uint32_t kept[batch_size];
  std::size_t count = 0;
  for (std::size_t i = 0; i < batch.count; i += double_lanes) {
    const std::size_t used = batch.count - i < double_lanes ? batch.count - i : double_lanes;
    const Point p = transform(input.T_cw, load_point(batch, i));
    p.x.store_aligned(batch.point[0] + i);
    p.y.store_aligned(batch.point[1] + i);
    p.z.store_aligned(batch.point[2] + i);
    Mask valid = is_positive(p.z) & (p.z >= Doubles(input.min_depth)) & is_finite(p.x) & is_finite(p.y);
    if (input.sigmas != nullptr) valid = valid & is_positive(load(batch.sigma, i));
    if (input.weights != nullptr) valid = valid & (load(batch.weight, i) >= Doubles(0.0));
    if (xsimd::all(valid)) {
      for (std::size_t lane = 0; lane < used; ++lane) kept[count++] = static_cast<std::uint32_t>(i + lane);
      continue;
    }
    const std::uint32_t valid_lanes = lanes_of(valid);
    const std::uint32_t behind = lanes_of(p.z <= Doubles(0.0));
    const std::uint32_t too_near = lanes_of((p.z > Doubles(0.0)) & (p.z < Doubles(input.min_depth)));
    for (std::uint32_t lane = 0; lane < used; ++lane) {
      kept[count] = static_cast<std::uint32_t>(i) + lane;
      count += valid_lanes >> lane & 1U;
      output.behind_camera += behind >> lane & 1U;
      output.too_near += too_near >> lane & 1U;
    }
  }
  if (count < batch.count) keep_matches(batch, kept, count);
}

}  // namespace
