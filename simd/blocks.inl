// SPDX-License-Identifier: MIT
// Blocks of points, rounded to float32 and stored together.
//
// Weighting and third row are template parameters. Whether an optional array is given is asked in the loop: that branch
// always goes the same way, and costs less than sixteen times the code.

namespace {

// Whether float32 holds every entry, by the sum of all magnitudes.
template <int Rows>
inline bool all_surely_held(const Doubles (&h)[Rows][dimension]) {
  Doubles sum(0.0);
  for (const auto& row : h) {
    for (const Doubles& entry : row) sum += xsimd::abs(entry);
  }
  return xsimd::all(sum < Doubles(1e38));
}

template <int Rows>
inline void store(const Doubles (&h)[Rows][dimension], float* entries, std::size_t stride) {
  for (int row = 0; row < Rows; ++row) {
    for (int column = 0; column < dimension; ++column) {
      store_narrow(h[row][column], entries + static_cast<std::size_t>(dimension * row + column) * stride);
    }
  }
}

inline void store_point(const Point& p, float* to, std::size_t stride) {
  store_narrow(p.x, to);
  store_narrow(p.y, to + stride);
  store_narrow(p.z, to + 2 * stride);
}

// A pack of blocks, one match per lane.
template <Weighting weighting, DepthCue third>
struct BlockPack {
  static constexpr bool is_world = weighting == Weighting::map_bias_world;
  static constexpr int rows = is_world ? 3 : rows_with(third);
  static constexpr bool is_factored = rows == 3 && !is_world;

  Point p;  // in the frame of the camera or body
  Mask has_third;
  Mask valid = Mask(true);
  Doubles h[rows][dimension];
};

// Of matches [i, i + double_lanes).
template <Weighting weighting, DepthCue third, bool by_jacobian>
[[gnu::always_inline]] inline void build_pack(const BlockInput& input, const Batch& batch, std::size_t i,
                                              BlockPack<weighting, third>& pack) {
  const Point p = load_point(batch, value::point, i);
  const Mask has_third = third_of<third>(input, batch, i);
  pack.p = p;
  pack.has_third = has_third;
  if constexpr (BlockPack<weighting, third>::is_world) {
    const Point ray = load_point(batch, by_jacobian ? value::ray : value::point, i);
    pack.valid = map_bias_world_block<third>(input.T_bw, ray, p, has_third, pack.h);
  } else {
    Factor<rows_with(third)> factor;
    if constexpr (by_jacobian) {
      pack.valid = factor_by_jacobian<weighting, third>(input, batch, i, has_third, factor);
    } else if constexpr (weighting == Weighting::map_bias) {
      factor = map_bias_factor<third>(p, has_third);
    } else if constexpr (weighting == Weighting::measurement) {
      pack.valid = measurement_factor<third>(input, batch, i, p, has_third, factor);
    } else {
      pack.valid = whitened_factor<third>(input, batch, i, p, has_third, factor);
    }
    multiply_by_point_jacobian(factor, p, pack.h);
  }
}

// append_pack and append_lanes set `has_three_rows` if a stored block has a third row.

// A whole pack of valid matches.
template <Weighting weighting, DepthCue third>
[[gnu::always_inline]] inline void append_pack(const BlockPack<weighting, third>& pack, const std::uint32_t* numbers,
                                               bool& has_three_rows, BlockOutput& output) {
  float* const planes = output.planes + output.stored;
  std::uint32_t* const indices = output.indices + output.stored;
  store(pack.h, planes, output.stride);
  if (pack.is_factored) store_point(pack.p, planes + point_plane * output.stride, output.stride);
  for (std::size_t lane = 0; lane < double_lanes; ++lane) {
    indices[lane] = output.first_index + numbers[lane];
    output.validity[numbers[lane]] = 1;
  }
  output.stored += double_lanes;
  has_three_rows = has_three_rows || (third != DepthCue::none && xsimd::any(pack.has_third));
}

// The valid ones of the first `used` lanes, by way of a copy.
template <Weighting weighting, DepthCue third>
[[gnu::always_inline]] inline void append_lanes(const BlockPack<weighting, third>& pack, const std::uint32_t* numbers,
                                                std::size_t used, bool& has_three_rows, BlockOutput& output) {
  constexpr std::size_t entries = std::size_t{BlockPack<weighting, third>::rows} * dimension;
  constexpr auto reason =
      BlockPack<weighting, third>::is_world ? maxlogdet::simd::singular_ray : maxlogdet::simd::invalid_covariance;
  float* const planes = output.planes + output.stored;
  std::uint32_t* const indices = output.indices + output.stored;
  float copy[entries * double_lanes];
  float point[3 * double_lanes];
  store(pack.h, copy, double_lanes);
  store_point(pack.p, point, double_lanes);
  const std::uint32_t valid_lanes = lanes_of(pack.valid);
  const std::uint32_t three_row_lanes = lanes_of(pack.has_third);
  std::size_t kept = 0;
  for (std::size_t lane = 0; lane < used; ++lane) {
    const bool is_valid = (valid_lanes >> lane & 1U) != 0;
    output.invalid[reason] += is_valid ? 0 : 1;
    bool is_held = true;
    for (std::size_t e = 0; e < entries; ++e) {
      const float entry = copy[e * double_lanes + lane];
      planes[e * output.stride + kept] = entry;
      is_held = is_held && is_finite(static_cast<double>(entry));
    }
    if (!is_valid || !is_held) continue;
    for (std::size_t d = 0; pack.is_factored && d < 3; ++d) {
      planes[(point_plane + d) * output.stride + kept] = point[d * double_lanes + lane];
    }
    indices[kept++] = output.first_index + numbers[lane];
    output.validity[numbers[lane]] = 1;
    has_three_rows = has_three_rows || (three_row_lanes >> lane & 1U) != 0;
  }
  output.stored += kept;
}

inline void summarise(std::size_t rows, bool has_three_rows, bool is_factored, BlockOutput& output) {
  output.rows_written = static_cast<int>(rows);
  output.rows = output.stored == 0 ? 0 : (has_three_rows ? 3 : 2);
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

template <Weighting weighting, DepthCue third, bool by_jacobian>
void build_blocks_of(const BlockInput& given, BlockOutput& output) {
  using Pack = BlockPack<weighting, third>;
  double pose[12];  // copies, so that no store can change them
  std::memcpy(pose, given.T_bw, sizeof pose);
  BlockInput input = given;
  input.T_bw = pose;
  Batch batch;
  bool has_three_rows = Pack::is_world;
  output.stored = 0;
  for (std::size_t& count : output.invalid) count = 0;
  std::memset(output.validity, 0, input.size);
  for (std::size_t next = 0; next < input.size;) {
    next = list_usable(input, next, batch, output);
    if (batch.count == 0) break;
    fill<weighting, third, by_jacobian>(input, batch);
    if constexpr (by_jacobian) linearise<weighting, third>(input, batch);
    filter<by_jacobian>(input, batch, output);
    for (std::size_t i = 0; i < batch.count; i += double_lanes) {
      const std::size_t used = batch.count - i < double_lanes ? batch.count - i : double_lanes;
      Pack pack;
      build_pack<weighting, third, by_jacobian>(input, batch, i, pack);
      if (used == double_lanes && xsimd::all(pack.valid) && all_surely_held(pack.h)) {
        append_pack(pack, batch.number + i, has_three_rows, output);
      } else {
        append_lanes(pack, batch.number + i, used, has_three_rows, output);
      }
    }
  }
  summarise(Pack::rows, has_three_rows, Pack::is_factored, output);
}

template <Weighting weighting, bool by_jacobian>
void build_blocks_weighted(const BlockInput& input, BlockOutput& output) {
  // By the map's bias a block asks only whether a match has a third measurement.
  constexpr DepthCue depth = is_by_map_bias(weighting) ? DepthCue::stereo : DepthCue::depth;
  switch (input.third) {
    case DepthCue::none: return build_blocks_of<weighting, DepthCue::none, by_jacobian>(input, output);
    case DepthCue::stereo: return build_blocks_of<weighting, DepthCue::stereo, by_jacobian>(input, output);
    case DepthCue::depth: return build_blocks_of<weighting, depth, by_jacobian>(input, output);
  }
}

template <Weighting weighting>
void build_blocks_weighted(const BlockInput& input, BlockOutput& output) {
  is_by_jacobian(input) ? build_blocks_weighted<weighting, true>(input, output)
                        : build_blocks_weighted<weighting, false>(input, output);
}

void build_blocks(const BlockInput& input, BlockOutput& output) {
  switch (input.weighting) {
    case Weighting::map_bias: return build_blocks_weighted<Weighting::map_bias>(input, output);
    case Weighting::map_bias_world: return build_blocks_weighted<Weighting::map_bias_world>(input, output);
    case Weighting::measurement: return build_blocks_weighted<Weighting::measurement>(input, output);
    case Weighting::measurement_and_map: return build_blocks_weighted<Weighting::measurement_and_map>(input, output);
  }
}

}  // namespace
