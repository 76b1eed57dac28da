// SPDX-License-Identifier: MIT
// The rest of a round: which tiles to screen, who survives, and, of lazy greedy, a whole round.

namespace {

std::size_t list_between(const float* values, std::size_t count, std::size_t part, std::size_t parts, float lower,
                         float upper, std::uint32_t* list) {
  std::size_t found = 0;
  for (std::size_t first = tile_size * part; first < count; first += tile_size * parts) {
    for (std::size_t i = first; i < first + tile_size; i += float_lanes) {
      const Floats value = Floats::load_unaligned(values + i);
      found +=
          list_lanes((value >= Floats(lower)) & (value <= Floats(upper)), static_cast<std::uint32_t>(i), list + found);
    }
  }
  while (found > 0 && list[found - 1] >= count) --found;  // beyond the end of values
  return found;
}

template <Form form>
ScreenedTiles screen_between(const Tiles& tiles, const float* w, const float* bounds, std::size_t tile_count,
                             std::size_t part, std::size_t parts, float lower, float upper, std::uint32_t* list,
                             float* relative_gains, float* highest) {
  const std::size_t count = list_between(bounds, tile_count, part, parts, lower, upper, list);
  return {count, screen<form>(tiles, w, list, count, relative_gains, highest)};
}

template <Form form>
std::size_t list_survivors(const Tiles& tiles, const float* relative_gains, const float* highest, float threshold,
                           const std::uint32_t* list, std::size_t count, const float* unlike, std::uint32_t* lanes) {
  std::size_t found = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const std::uint32_t tile = list[j];
    if (highest[tile] < threshold) continue;
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      const std::size_t at = tile * tile_size + lane;
      auto survives = Floats::load_unaligned(relative_gains + at) >= Floats(threshold);
      if (unlike != nullptr) {
        const float* entries = tiles.data + tile * tiles.tile_stride + lane;
        auto is_same = survives;
        for (std::size_t e = 0; e < entries_of(form); ++e, entries += tiles.entry_stride) {
          is_same = is_same & (Floats::load_unaligned(entries) == Floats(unlike[e]));
        }
        survives = survives & !is_same;
      }
      found += list_lanes(survives, static_cast<std::uint32_t>(at), lanes + found);
    }
  }
  return found;
}

float largest(const float* values, std::size_t count) {
  alignas(sizeof(Floats)) static constexpr float numbers[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const Floats lane = Floats::load_aligned(numbers);
  const Floats nothing(-1.0F);
  Floats maxima = nothing;
  std::size_t i = 0;
  for (; i + float_lanes <= count; i += float_lanes) maxima = xsimd::max(maxima, Floats::load_unaligned(values + i));
  if (i < count) {
    const auto is_one = lane < Floats(static_cast<float>(count - i));
    maxima = xsimd::max(maxima, xsimd::select(is_one, Floats::load_unaligned(values + i), nothing));
  }
  return largest_lane(maxima);
}

// The proofs of what follows are in docs/numerics.md.

// Screens the tiles with lower <= bound <= upper. Returns whether the bound by slope and offset is tight for the best.
template <Form form>
inline bool screen_down_to(const Tiles& tiles, const float* w, float lower, float upper, PromisingRound& round) {
  std::uint32_t* const list = round.list + round.listed;
  const std::size_t count = list_between(round.bounds, round.tile_count, 0, 1, lower, upper, list);
  round.lowest_listed = lower;
  round.listed += count;
  const float best = screen<form>(tiles, w, list, count, round.relative_gains, round.highest);
  round.best = best > round.best ? best : round.best;
  const auto relative_gain = static_cast<double>(round.best);
  round.assured = round.line.at_least(relative_gain);
  return relative_gain > round.tight_above && relative_gain < round.tight_below;
}

template <Form form>
inline void list_survivors_of_round(const Tiles& tiles, PromisingRound& round) {
  const float threshold = round.line.survivor_threshold(round.assured);
  std::size_t holders = 0;  // tiles with survivors, usually one
  std::uint32_t holder = 0;
  for (std::size_t j = 0; j < round.listed; ++j) {
    const std::uint32_t tile = round.list[j];
    const bool holds = round.highest[tile] >= threshold;
    holder = holds ? tile : holder;
    holders += holds ? 1 : 0;
  }
  const bool is_one = holders == 1;
  round.survivors =
      list_survivors<form>(tiles, round.relative_gains, round.highest, threshold, is_one ? &holder : round.list,
                           is_one ? 1 : round.listed, nullptr, round.lanes);
}

inline void update_bounds(PromisingRound& round) {
  const TileLine line = rounded_up(round.line);
  for (std::size_t j = 0; j < round.listed; ++j) {
    const std::uint32_t tile = round.list[j];
    round.bounds[tile] = line.at(round.highest[tile]);
  }
  round.highest_bound = largest(round.bounds, round.tile_count);
}

template <Form form>
void screen_promising(const Tiles& tiles, const float* w, PromisingRound& round) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  if (!screen_down_to<form>(tiles, w, round.first_threshold, infinity, round)) return;
  const float threshold = stale_threshold(round.assured, round.drift);
  const bool is_lower = threshold < round.first_threshold;
  if (is_lower && !screen_down_to<form>(tiles, w, threshold, next_below(round.first_threshold), round)) return;
  round.is_done = true;
  list_survivors_of_round<form>(tiles, round);
  update_bounds(round);
}

}  // namespace
