// SPDX-License-Identifier: MIT
// The end of a round: who survives, and what is kept for later rounds.

namespace maxlogdet::simd {
namespace {

// Which of a pack of tiles are evaluated.
inline Floats::batch_bool_type are_evaluated(const RoundArrays& arrays, std::size_t tile, float evaluated_from) {
  return Floats::load_unaligned(arrays.bounds + tile) >= Floats(evaluated_from);
}

std::size_t list_survivors(const Tiles& tiles, const Round& round, Lane* lanes) {
  const RoundArrays& arrays = round.arrays;
  const float threshold = round.filter.survivor_threshold(round.assured);
  std::size_t found = 0;
  for (std::size_t first = 0; first < tiles.count; first += float_lanes) {
    const auto reach = Floats::load_unaligned(arrays.highest + first) >= Floats(threshold);
    const auto holds = reach & are_evaluated(arrays, first, round.evaluated_from);
    for (std::uint32_t bits = lane_mask(holds); bits != 0; bits &= bits - 1) {
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
