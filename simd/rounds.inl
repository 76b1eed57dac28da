// SPDX-License-Identifier: MIT
// A round of lazy greedy: which tiles to evaluate, who survives, and what is kept for later rounds.

namespace {

// The tiles of a part of all runs of 16 tiles that reach this stale bound, and that the round has not evaluated. Up to a
// pack more than are listed is written. Bounds beyond the last tile are -1.
inline std::size_t list_unevaluated(const Tiles& tiles, const RoundArrays& arrays, float from, const Part& part,
                                    Tile* list) {
  std::size_t found = 0;
  for (std::size_t first = tile_size * part.index; first < tiles.count; first += tile_size * part.count) {
    for (std::size_t tile = first; tile < first + tile_size; tile += float_lanes) {
      const auto reaches = Floats::load_unaligned(arrays.bounds + tile) >= Floats(from);
      const auto is_left = Floats::load_unaligned(arrays.highest + tile) == Floats(not_evaluated);
      found += list_lanes(reaches & is_left, static_cast<Tile>(tile), list + found);
    }
  }
  return found;
}

inline std::size_t remaining_in(const Tiles& tiles, const Tile* list, std::size_t count) {
  std::size_t sum = 0;
  for (std::size_t j = 0; j < count; ++j) sum += tiles.in_each[number(list[j])];
  return sum;
}

template <Form form, bool with_care>
Evaluated evaluate(const Tiles& tiles, const float* w, const RoundArrays& arrays, float from, const Part& part) {
  Tile* const list = arrays.list + part.first_of_list;
  const std::size_t count = list_unevaluated(tiles, arrays, from, part, list);
  const float best = with_care ? evaluate_listed_with_care<form>(tiles, w, list, count, arrays)
                               : evaluate_listed<form>(tiles, w, list, count, arrays);
  return {best, remaining_in(tiles, list, count)};
}

std::size_t list_survivors(const Tiles& tiles, const RoundArrays& arrays, float threshold, Lane* lanes) {
  std::size_t found = 0;
  for (std::size_t first = 0; first < tiles.count; first += float_lanes) {
    const auto holds = Floats::load_unaligned(arrays.highest + first) >= Floats(threshold);
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
float keep_bounds(const Tiles& tiles, const RoundArrays& arrays, const GainFilter& filter) {
  const TileLine line = filter.line_of_tiles();
  const Floats nothing(-1.0F);
  Floats highest_bound = nothing;
  for (std::size_t tile = 0; tile < tiles.count; tile += float_lanes) {
    const Floats highest = Floats::load_unaligned(arrays.highest + tile);
    const Floats before = Floats::load_unaligned(arrays.bounds + tile);
    const Floats on_line = Floats(line.slope) * highest + Floats(line.offset);
    const Floats fresh = xsimd::select(highest < Floats(0.0F), nothing, on_line);
    const Floats bound = xsimd::select(highest == Floats(not_evaluated), before, fresh);
    bound.store_unaligned(arrays.bounds + tile);
    highest_bound = xsimd::max(highest_bound, bound);
  }
  return largest_lane(highest_bound);
}

float highest_unevaluated(const Tiles& tiles, const RoundArrays& arrays) {
  Floats highest_bound(any_candidate);
  for (std::size_t tile = 0; tile < tiles.count; tile += float_lanes) {
    const auto is_left = Floats::load_unaligned(arrays.highest + tile) == Floats(not_evaluated);
    const Floats bound = xsimd::select(is_left, Floats::load_unaligned(arrays.bounds + tile), Floats(any_candidate));
    highest_bound = xsimd::max(highest_bound, bound);
  }
  return largest_lane(highest_bound);
}

// The steps of a round for one candidate, on one thread, without care: all in this unit, so that they are inlined.
template <Form form>
struct InlinedSteps {
  const Tiles& tiles;
  const float* w;

  float best(const Round& round) const { return round.best; }
  float highest_left(const Round& round) const { return highest_unevaluated(tiles, round.arrays); }
  float evaluate(Round& round, float from) const {
    const Evaluated found = ::evaluate<form, false>(tiles, w, round.arrays, from, {0, 1, 0});
    round.evaluations += found.count;
    round.best = found.best > round.best ? found.best : round.best;
    return from;
  }
};

template <Form form>
void run_round(const Tiles& tiles, const float* w, Round& round) {
  InlinedSteps<form> steps{tiles, w};
  prove_best(round, steps);
  round.survivors =
      list_survivors(tiles, round.arrays, round.filter.survivor_threshold(round.assured), round.arrays.survivors);
  round.highest_bound = keep_bounds(tiles, round.arrays, round.filter);
}

}  // namespace
