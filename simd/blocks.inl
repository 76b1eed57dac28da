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
template <BlockWeighting weighting, ThirdRow third>
struct BlockPack {
  static constexpr bool is_world = weighting == BlockWeighting::map_bias_world;
  static constexpr int rows = third == ThirdRow::none && !is_world ? 2 : 3;
  static constexpr bool is_factored = rows == 3 && !is_world;

  Point p;
  Mask has_third = Mask(third != ThirdRow::none);
  Mask valid = Mask(true);
  Mask is_singular = Mask(false);
  Doubles h[rows][dimension];
};

// Of matches [i, i + double_lanes); of a SeenBatch p is in the body's frame.
template <BlockWeighting weighting, ThirdRow third, class AnyBatch>
[[gnu::always_inline]] inline void build_pack(const BlockInput& input, const AnyBatch& batch, std::size_t i,
                                              BlockPack<weighting, third>& pack) {
  constexpr bool is_general = std::is_same<AnyBatch, SeenBatch>::value;
  using Pack = BlockPack<weighting, third>;
  pack.p = load_point(batch, i);
  if (third != ThirdRow::none && input.has_third != nullptr) pack.has_third = load(batch.has_third, i) > Doubles(0.0);
  if constexpr (Pack::is_world) {
    Point ray = pack.p;
    if constexpr (is_general) ray = {load(batch.ray[0], i), load(batch.ray[1], i), load(batch.ray[2], i)};
    pack.is_singular = map_bias_world_block<third>(input.T_cw, ray, pack.p, pack.has_third, pack.h);
    pack.valid = !pack.is_singular;
  } else {
    Factor<Pack::rows> factor;
    if constexpr (is_general) {
      pack.valid = seen_factor<weighting, third>(input, batch, i, pack.has_third, factor);
    } else if constexpr (weighting == BlockWeighting::map_bias) {
      factor = map_bias_factor<third, Pack::rows>(pack.p, pack.has_third);
    } else if constexpr (weighting == BlockWeighting::measurement) {
      pack.valid = measurement_factor<third>(input, batch, i, pack.p, pack.has_third, factor);
    } else {
      pack.valid = whitened_factor<third>(input, batch, i, pack.p, pack.has_third, factor);
    }
    multiply_by_point_jacobian(factor, pack.p, pack.h);
  }
  if (input.weights == nullptr) return;
  const Doubles root_weight = xsimd::sqrt(load(batch.weight, i));
  for (auto& row : pack.h) {
    for (Doubles& entry : row) entry *= root_weight;
  }
}

// append_pack and append_lanes set `has_three_rows` if a stored block has a third row.

// A whole pack of valid matches.
template <BlockWeighting weighting, ThirdRow third>
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
  has_three_rows = has_three_rows || (third != ThirdRow::none && xsimd::any(pack.has_third));
}

// The valid ones of the first `used` lanes, by way of a copy.
template <BlockWeighting weighting, ThirdRow third>
[[gnu::always_inline]] inline void append_lanes(const BlockPack<weighting, third>& pack, const std::uint32_t* numbers,
                                                std::size_t used, bool& has_three_rows, BlockOutput& output) {
  constexpr std::size_t entries = std::size_t{BlockPack<weighting, third>::rows} * dimension;
  float* const planes = output.planes + output.stored;
  std::uint32_t* const indices = output.indices + output.stored;
  float copy[entries * double_lanes];
  float point[3 * double_lanes];
  store(pack.h, copy, double_lanes);
  store_point(pack.p, point, double_lanes);
  const std::uint32_t valid_lanes = lanes_of(pack.valid & are_held(pack.h));
  const std::uint32_t three_row_lanes = lanes_of(pack.has_third);
  const std::uint32_t singular_lanes = lanes_of(pack.is_singular);
  const std::uint32_t unsound_lanes = pack.is_world ? 0U : lanes_of(!pack.valid);
  std::size_t kept = 0;
  for (std::size_t lane = 0; lane < used; ++lane) {
    output.singular_rays += singular_lanes >> lane & 1U;
    output.invalid_covariances += unsound_lanes >> lane & 1U;
    if ((valid_lanes >> lane & 1U) == 0) continue;
    for (std::size_t e = 0; e < entries; ++e) planes[e * output.stride + kept] = copy[e * double_lanes + lane];
    for (std::size_t d = 0; pack.is_factored && d < 3; ++d) {
      planes[(point_plane + d) * output.stride + kept] = point[d * double_lanes + lane];
    }
    indices[kept++] = output.first_index + numbers[lane];
    output.validity[numbers[lane]] = 1;
    has_three_rows = has_three_rows || (three_row_lanes >> lane & 1U) != 0;
  }
  output.stored += kept;
}

inline void clear(BlockOutput& output, std::size_t size) {
  output.stored = output.unusable = output.behind_camera = output.too_near = output.singular_rays = 0;
  output.invalid_covariances = output.invalid_jacobians = 0;
  std::memset(output.validity, 0, size);
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

template <BlockWeighting weighting, ThirdRow third, bool is_general>
void build_blocks_of(const BlockInput& given, BlockOutput& output) {
  using Pack = BlockPack<weighting, third>;
  double pose[12];  // copies, so that no store can change them
  for (int e = 0; e < 12; ++e) pose[e] = given.T_cw[e];
  BlockInput input = given;
  input.T_cw = pose;
  std::conditional_t<is_general, SeenBatch, Batch> batch;
  bool has_three_rows = Pack::is_world;
  clear(output, input.size);
  for (std::size_t next = 0; next < input.size;) {
    next = list_usable(input, next, batch, output);
    if (batch.count == 0) break;
    fill<weighting, third>(input, batch);
    if constexpr (is_general) {
      linearise_and_filter<weighting, third>(input, batch, output);
    } else {
      transform_and_filter(input, batch, output);
    }
    for (std::size_t i = 0; i < batch.count; i += double_lanes) {
      const std::size_t used = batch.count - i < double_lanes ? batch.count - i : double_lanes;
      Pack pack;
      build_pack(input, batch, i, pack);
      if (used == double_lanes && xsimd::all(pack.valid) && all_surely_held(pack.h)) {
        append_pack(pack, batch.number + i, has_three_rows, output);
      } else {
        append_lanes(pack, batch.number + i, used, has_three_rows, output);
      }
    }
  }
  summarise(Pack::rows, has_three_rows, Pack::is_factored, output);
}

template <BlockWeighting weighting, bool is_general>
void build_blocks_weighted(const BlockInput& input, BlockOutput& output) {
  // Both weightings by the map's bias ask only whether a match has a third measurement.
  constexpr bool is_map_bias = weighting == BlockWeighting::map_bias || weighting == BlockWeighting::map_bias_world;
  constexpr ThirdRow depth = is_map_bias ? ThirdRow::stereo : ThirdRow::depth;
  switch (input.third) {
    case ThirdRow::none: return build_blocks_of<weighting, ThirdRow::none, is_general>(input, output);
    case ThirdRow::stereo: return build_blocks_of<weighting, ThirdRow::stereo, is_general>(input, output);
    case ThirdRow::depth: return build_blocks_of<weighting, depth, is_general>(input, output);
  }
}

template <bool is_general>
void build_blocks_of_cameras(const BlockInput& input, BlockOutput& output) {
  switch (input.weighting) {
    case BlockWeighting::map_bias: return build_blocks_weighted<BlockWeighting::map_bias, is_general>(input, output);
    case BlockWeighting::map_bias_world:
      return build_blocks_weighted<BlockWeighting::map_bias_world, is_general>(input, output);
    case BlockWeighting::measurement:
      return build_blocks_weighted<BlockWeighting::measurement, is_general>(input, output);
    case BlockWeighting::measurement_and_map:
      return build_blocks_weighted<BlockWeighting::measurement_and_map, is_general>(input, output);
  }
}

void build_blocks(const BlockInput& input, BlockOutput& output) {
  input.is_general ? build_blocks_of_cameras<true>(input, output) : build_blocks_of_cameras<false>(input, output);
}

}  // namespace
