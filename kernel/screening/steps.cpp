// SPDX-License-Identifier: MIT
#include "kernel/screening/steps.hpp"

#include <algorithm>

namespace maxlogdet {

using simd::tile_size;

namespace {

constexpr std::size_t min_tiles = 256;      // per chunk in float32: most of them are not evaluated
constexpr std::size_t min_exact_tiles = 8;  // per chunk in float64

}  // namespace

// Collects the values of the evaluated tiles, or of each the largest; returns how many.
std::size_t CalledSteps::rank(const simd::Round& round, bool by_tiles) const noexcept {
  float* const ranked = memory_.ranked;
  std::size_t count = 0;
  for (std::size_t tile = 0; tile < tiles_.tiles().count; ++tile) {
    if (!(memory_.bounds.data()[tile] >= round.evaluated_from)) continue;
    if (by_tiles) {
      ranked[count++] = memory_.highest.data()[tile];
    } else {
      std::copy_n(memory_.gains.data() + tile_size * tile, tile_size, ranked + count);
      count += tile_size;
    }
  }
  return count;
}

float CalledSteps::best(const simd::Round& round) const noexcept {
  if (!round.has_evaluated()) return -1;
  if (k_ == 1 && !goes_on_) return found_;
  if (k_ == 1) return evaluator_.kernel().bounds.highest_evaluated(tiles_.tiles(), round);
  std::size_t count = rank(round, true);
  if (count < k_) count = rank(round, false);
  float* const ranked = memory_.ranked;
  if (count < k_) return -1;
  std::nth_element(ranked, ranked + (k_ - 1), ranked + count, [](float a, float b) { return a > b; });
  return ranked[k_ - 1];
}

// In a round that goes on, a little lower than needed: the next removal may need it.
float CalledSteps::evaluate(simd::Round& round, float from) noexcept {
  if (goes_on_ && from > 0) from *= 0.98F;
  errors_.in_float64() ? evaluate_in_float64(round, from) : evaluate_in_float32(round, from);
  return from;
}

void CalledSteps::note(simd::Round& round, const simd::Evaluated& found) noexcept {
  round.evaluations += found.count;
  found_ = std::max(found_, found.best);
}

// Chunks are strided because promising tiles are adjacent.
void CalledSteps::evaluate_in_float32(simd::Round& round, float from) noexcept {
  threading::Team& team = evaluator_.team();
  const simd::Tiles& tiles = tiles_.tiles();
  const auto function = evaluator_.kernel().rounds[tiles_.form()].evaluate;
  simd::Evaluated found[threading::Team::max_chunks];
  const std::uint32_t chunks = team.chunks_of(tiles.count, min_tiles);
  const std::size_t room = (tiles_of(tiles.count) / chunks + 2) * tile_size;  // in the list, for each chunk
  // Runs on helpers: writes `gains` and `highest` of its own tiles, and its own parts of `list` and `found`.
  team.for_chunks(chunks, [&](std::uint32_t chunk) {
    found[chunk] = function(tiles, factor_.narrow_inverse(), round, from, {chunk, chunks, room * chunk});
  });
  for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) note(round, found[chunk]);
}

void CalledSteps::evaluate_in_float64(simd::Round& round, float from) noexcept {
  const simd::Tiles& tiles = tiles_.tiles();
  Tile* const list = memory_.list;
  const std::size_t count =
      evaluator_.kernel().arrays.list_tiles(memory_.bounds.data(), tiles.count, from, round.evaluated_from, list);
  const simd::BlocksOfLanes blocks{evaluator_.planes(),
                                   tiles_.is_store_order() ? nullptr : memory_.tiles.candidate.data()};
  simd::Evaluated found[threading::Team::max_chunks];
  // Runs on helpers: writes `gains` and `highest` of its own tiles, and its own part of `found`.
  const std::uint32_t chunks = evaluator_.team().in_chunks(
      count, min_exact_tiles, 1, [&](std::size_t first, std::size_t size, std::uint32_t chunk) {
        found[chunk] = evaluator_.exact().evaluate(tiles, blocks, factor_.inverse(), errors_.by_elimination(),
                                                   list + first, size, round.arrays);
      });
  for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) note(round, found[chunk]);
}

}  // namespace maxlogdet
