// SPDX-License-Identifier: MIT
// What is asked of arrays of float32: medians, and in a round which tiles to evaluate, who survives, and what is kept.

namespace maxlogdet::simd {
namespace {

std::size_t list_tiles(const float* values, std::size_t count, float lower, float upper, Tile* list) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += float_lanes) {
    const Floats value = Floats::load_unaligned(values + i);
    found += list_lanes((value >= Floats(lower)) & !(value >= Floats(upper)), static_cast<Tile>(i), list + found);
  }
  while (found > 0 && number(list[found - 1]) >= count) --found;  // beyond the end of values
  return found;
}

float largest(const float* values, std::size_t count) {
  Floats maxima(-1.0F);
  std::size_t i = 0;
  for (; i + float_lanes <= count; i += float_lanes) maxima = xsimd::max(maxima, Floats::load_unaligned(values + i));
  float most = largest_lane(maxima);
  for (; i < count; ++i) most = values[i] > most ? values[i] : most;
  return most;
}

void measure_sizes(const float* planes, std::size_t stride, int rows, std::size_t count, float* sizes) {
  const Floats infinite(std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < count; i += float_lanes) {
    Floats size(0.0F);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < 3; ++column) {
        const float* const plane = planes + static_cast<std::size_t>(dimension * row + column) * stride;
        size = xsimd::max(size, xsimd::abs(Floats::load_unaligned(plane + i)));
      }
    }
    xsimd::select(size > Floats(0.0F), size, infinite).store_aligned(sizes + i);
  }
}

inline std::size_t count_up_to(const float* values, std::size_t count, float limit) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; i += float_lanes) {
    found += static_cast<std::size_t>(__builtin_popcount(lane_mask(Floats::load_aligned(values + i) <= Floats(limit))));
  }
  return found;
}

// By bisection of the bits of a float, which are ordered as floats that are not negative: no branch depends on a value.
float median(const float* values, std::size_t count, std::size_t& finite) {
  constexpr std::uint32_t steps = 0x7F800000U >> rounded_bits;
  const auto end_of = [](std::uint32_t step) {
    const std::uint32_t bits = ((step + 1) << rounded_bits) - 1;
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  };
  finite = count_up_to(values, count, end_of(steps - 1));
  std::uint32_t low = 0, high = steps - 1;
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    const bool is_enough = 2 * count_up_to(values, count, end_of(middle)) >= finite;
    is_enough ? high = middle : low = middle + 1;
  }
  return end_of(low);
}

std::size_t list_survivors(const Tiles& tiles, const Round& round, Lane* lanes) {
  const RoundArrays& arrays = round.arrays;
  const float threshold = round.filter.survivor_threshold(round.assured);
  std::size_t found = 0;
  for (std::size_t first = 0; first < tiles.count; first += float_lanes) {
    const auto reach = Floats::load_unaligned(arrays.highest + first) >= Floats(threshold);
    const auto is_evaluated = Floats::load_unaligned(arrays.bounds + first) >= Floats(round.evaluated_from);
    for (std::uint32_t bits = lane_mask(reach & is_evaluated); bits != 0; bits &= bits - 1) {
      const std::size_t tile = first + static_cast<std::size_t>(__builtin_ctz(bits));
      for (std::size_t lane = tile * tile_size; lane < (tile + 1) * tile_size; lane += float_lanes) {
        const auto survives = Floats::load_unaligned(arrays.gains + lane) >= Floats(threshold);
        found += list_lanes(survives, static_cast<Lane>(lane), lanes + found);
      }
    }
  }
  return found;
}

// The bounds of the tiles that this round has evaluated, for later rounds; returns the largest of all.
float keep_bounds(const Tiles& tiles, const Round& round) {
  const TileLine line = round.filter.line_of_tiles();
  const Floats none(-1.0F);
  Floats highest_bound = none;
  for (std::size_t tile = 0; tile < tiles.count; tile += float_lanes) {
    const Floats highest = Floats::load_unaligned(round.arrays.highest + tile);
    const Floats on_line = Floats(line.slope) * highest + Floats(line.offset);
    const Floats fresh = xsimd::select(highest < Floats(0.0F), none, on_line);
    const Floats before = Floats::load_unaligned(round.arrays.bounds + tile);
    const Floats bound = xsimd::select(before >= Floats(round.evaluated_from), fresh, before);
    bound.store_unaligned(round.arrays.bounds + tile);
    highest_bound = xsimd::max(highest_bound, bound);
  }
  return largest_lane(highest_bound);
}

float highest_unevaluated(const Tiles& tiles, const Round& round) {
  Floats highest_bound(any_candidate);
  for (std::size_t tile = 0; tile < tiles.count; tile += float_lanes) {
    const Floats bound = Floats::load_unaligned(round.arrays.bounds + tile);
    const auto is_evaluated = bound >= Floats(round.evaluated_from);
    highest_bound = xsimd::max(highest_bound, xsimd::select(is_evaluated, Floats(any_candidate), bound));
  }
  return largest_lane(highest_bound);
}

}  // namespace
}  // namespace maxlogdet::simd
