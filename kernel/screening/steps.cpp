// SPDX-License-Identifier: MIT
#include "kernel/screening/steps.hpp"

#include <algorithm>

namespace maxlogdet {

using simd::tile_size;

namespace {

constexpr std::size_t min_tiles = 256;  // per chunk: most of them are not evaluated

}  // namespace

// Collects the values of the evaluated tiles, or of each the largest; returns how many.
std::size_t CalledSteps::rank(const simd::Round& round, bool by_tiles) const noexcept {
  const float* const values = with_care_ ? memory_.lower.data() : memory_.gains.data();
  float* const ranked = memory_.ranked;
  std::size_t count = 0;
  for (std::size_t tile = 0; tile < tiles_.tiles().count; ++tile) {
    if (!(memory_.bounds.data()[tile] >= round.evaluated_from)) continue;
    const float* const lanes = values + tile_size * tile;
    if (!by_tiles) {
      std::copy_n(lanes, tile_size, ranked + count);
      count += tile_size;
    } else {
      ranked[count++] =
          with_care_ ? evaluator_.kernel().arrays.largest(lanes, tile_size) : memory_.highest.data()[tile];
    }
  }
  return count;
}

float CalledSteps::best(const simd::Round& round) const noexcept {
  if (!round.has_evaluated()) return -1;
  if (k_ == 1 && !goes_on_) return found_;
  if (k_ == 1 && !with_care_) return evaluator_.kernel().bounds.highest_evaluated(tiles_.tiles(), round);
  std::size_t count = rank(round, true);
  if (count < k_) count = rank(round, false);
  float* const ranked = memory_.ranked;
  if (count < k_) return -1;
  std::nth_element(ranked, ranked + (k_ - 1), ranked + count, [](float a, float b) { return a > b; });
  return ranked[k_ - 1];
}

// In a round that goes on, a little lower than needed: the next removal may need it. Chunks are strided because
// promising tiles are adjacent.
float CalledSteps::evaluate(simd::Round& round, float from) noexcept {
  if (goes_on_ && from > 0) from *= 0.98F;
  threading::Team& team = evaluator_.team();
  const simd::Tiles& tiles = tiles_.tiles();
  const simd::RoundFunctions& functions = evaluator_.kernel().rounds[tiles_.form()];
  const auto function = with_care_ ? functions.evaluate_with_care : functions.evaluate;
  simd::Evaluated found[threading::Team::max_chunks];
  const std::uint32_t chunks = team.chunks_of(tiles.count, min_tiles);
  const std::size_t room = (tiles_of(tiles.count) / chunks + 2) * tile_size;  // in the list, for each chunk
  // Runs on helpers: writes `gains`, `lower` and `highest` of its own tiles, and its own parts of `list` and `found`.
  team.for_chunks(chunks, [&](std::uint32_t chunk) {
    found[chunk] = function(tiles, w_, round, from, {chunk, chunks, room * chunk});
  });
  for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
    round.evaluations += found[chunk].count;
    found_ = std::max(found_, found[chunk].best);
  }
  return from;
}

}  // namespace maxlogdet
