// SPDX-License-Identifier: MIT
#include "kernel/screening/screening.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/screening/lane_order.hpp"

#include <algorithm>

namespace maxlogdet {

using simd::any_candidate;
using simd::tile_size;

ScreeningMemory::ScreeningMemory(std::size_t capacity)
    : tiles(capacity),
      relative_gains(lanes_for(capacity)),
      lower(lanes_for(capacity)),
      ranked(lanes_for(capacity)),
      survivors(lanes_for(capacity)),
      highest(lanes_for(tiles_of(capacity))),
      bounds(lanes_for(tiles_of(capacity))),
      list(2 * lanes_for(tiles_of(capacity)) + 2 * tile_size * threading::Team::max_chunks) {}

void Screening::use_store(const unsigned char* free, std::size_t n) noexcept {
  lists_all_ = false;
  tiles_.use_store(free, n);
}

void Screening::use_listed(const std::uint32_t* candidates, std::size_t count) noexcept {
  lists_all_ = false;
  tiles_.use_listed(candidates, count);
}

void Screening::order_by_gain(bool find_lanes) noexcept {
  const float top = std::max(0.0F, kernel_.largest(memory_.relative_gains, lanes()));
  errors_.restore(line_of_all_);
  const simd::TileLine line = simd::rounded_up(errors_.line());
  // The highest gain of a tile is below the upper end of its first lane's bucket.
  tiles_.order_by(memory_.relative_gains, top, [&](std::size_t tile, std::uint32_t bucket) {
    const std::int32_t below = static_cast<std::int32_t>(bucket) * (1 << lane_order_shift);
    memory_.bounds[tile] = line.at(float_of(bits_of(top) - below));
  });
  lists_all_ = false;
  highest_bound_ = kernel_.largest(memory_.bounds, tiles_.tile_count());
  if (find_lanes) tiles_.find_lanes();
  if (!errors_.is_small()) tiles_.find_column_max(errors_.column_max());
}

void Screening::begin_round(const InformationFactor& factor) noexcept {
  listed_ = 0;
  survivors_found_ = 0;
  are_bounds_kept_ = false;
  best_ = -1;
  assured_ = -1;
  w_ = factor.narrow_inverse();
  errors_.begin_round(factor, tiles_.is_ordered(), highest_bound_);
}

void Screening::evaluate_all() noexcept {
  if (!lists_all_) {
    for (std::size_t tile = 0; tile < tiles_.tile_count(); ++tile)
      memory_.list[tile] = static_cast<std::uint32_t>(tile);
    lists_all_ = true;
  }
  listed_ = tiles_.tile_count();
  lowest_listed_ = -float_infinity;
  errors_.set_tangent(0);
  evaluate_listed();
  line_of_all_ = errors_.line();
  evaluations_ += tiles_.remaining();
}

void Screening::evaluate_trial(float min_bound) noexcept {
  const float threshold = std::max(0.0F, min_bound);
  errors_.set_tangent(static_cast<double>(threshold));
  evaluate_between(threshold, float_infinity);
}

// First evaluates the tiles whose stale bound reaches about the expected best relative gain, which is predicted from
// its share of the highest bound in earlier rounds. Their values then decide which others are evaluated.
void Screening::evaluate_promising(std::size_t k) noexcept {
  const bool is_first_look = listed_ == 0;
  if (is_first_look) {
    if (errors_.is_new()) tighten_errors();
    const float first_threshold = highest_bound_ < float_infinity ? first_share() * highest_bound_ : float_infinity;
    const bool is_alone = evaluator_.team().workers() == 1 && !are_withdrawn_;
    if (k == 1 && first_threshold > 0 && !errors_.with_care() && is_alone) {
      if (evaluate_at_once(first_threshold)) return;
    } else {
      evaluate_down_to(first_threshold);
    }
  }
  for (;;) {
    if (k > 1 || !is_first_look) look_again(k);
    // If too few of the listed candidates remain, first one step down.
    const float step = k == 1 ? first_share() : 0.5F;
    const float threshold = best_ < 0 ? step * highest_unlisted() : stale_threshold();
    if (!(threshold < lowest_listed_)) break;
    // A little lower than needed: the next rejection may need it.
    evaluate_down_to(is_first_look || threshold < 0 ? threshold : 0.98F * threshold);
  }
}

void Screening::tighten_errors() noexcept {
  const auto highest = static_cast<double>(highest_bound_);
  const bool is_known = highest_bound_ < float_infinity;
  is_known ? errors_.tighten(highest) : errors_.keep_wide(highest);
  errors_.set_tangent(is_known ? std::max(0.0, expected_share_ * highest) : 0);
}

void Screening::look_again(std::size_t k) noexcept {
  best_ = -1;
  assured_ = -1;
  learn_from(best_listed(k));
}

void Screening::keep_bounds() noexcept {
  const simd::TileLine line = simd::rounded_up(errors_.line());
  const std::uint32_t* const list = memory_.list;
  const float* const highest = memory_.highest;
  float* const bounds = memory_.bounds;
  for (std::size_t j = 0; j < listed_; ++j) bounds[list[j]] = line.at(highest[list[j]]);
  next_highest_bound_ = kernel_.largest(memory_.bounds, tiles_.tile_count());
  are_bounds_kept_ = true;
}

void Screening::end_round() noexcept {
  if (!are_bounds_kept_) keep_bounds();
  if (best_ > 0 && highest_bound_ > 0 && highest_bound_ < float_infinity) {
    // After rejections best_ is that of the remaining candidates: the next round should start as low.
    const double found = std::min(1.0, static_cast<double>(best_) / static_cast<double>(highest_bound_));
    expected_share_ += 0.5 * (found - expected_share_);
  }
  highest_bound_ = next_highest_bound_;
}

// Updates best_ and the lower bound assured_ by `best`, a result of evaluate().
void Screening::learn_from(float best) noexcept {
  best_ = std::max(best_, best);
  if (errors_.with_care()) assured_ = std::max(assured_, static_cast<double>(best));
  if (errors_.with_care() || best_ < 0) return;
  const auto relative_gain = static_cast<double>(best_);
  if (!errors_.is_tight_at(relative_gain)) errors_.set_tangent(relative_gain);
  assured_ = std::max(assured_, errors_.line().at_least(relative_gain));
}

// Tiles whose stale bound is below this threshold are excluded.
float Screening::stale_threshold() const noexcept { return simd::stale_threshold(assured_, errors_.drift()); }

// A share of the highest bound slightly below that expected of the best relative gain: in two rounds of three no other
// tile is needed.
float Screening::first_share() const noexcept {
  return static_cast<float>(std::max(0.25, 1.25 * expected_share_ - 0.25));
}

float Screening::highest_unlisted() const noexcept {
  float highest = any_candidate;
  for (std::size_t tile = 0; tile < tiles_.tile_count(); ++tile) {
    const float bound = memory_.bounds[tile];
    if (bound < lowest_listed_ && bound > highest) highest = bound;
  }
  return highest;
}

// A relative gain, or with care a lower bound of one, that at least k candidates in the listed tiles reach; below 0 if
// there are fewer.
float Screening::best_listed(std::size_t k) noexcept {
  const float* const values = errors_.with_care() ? memory_.lower : memory_.relative_gains;
  float* const all = memory_.ranked;
  std::size_t count = 0;
  if (k <= listed_) {  // the maxima of the tiles suffice
    for (std::size_t j = 0; j < listed_; ++j) {
      const std::uint32_t tile = memory_.list[j];
      all[count++] =
          errors_.with_care() ? kernel_.largest(values + tile_size * tile, tile_size) : memory_.highest[tile];
    }
  } else {
    for (std::size_t j = 0; j < listed_; ++j, count += tile_size) {
      std::copy_n(values + tile_size * memory_.list[j], tile_size, all + count);
    }
  }
  if (k == 1) return count == 0 ? -1.0F : *std::max_element(all, all + count);
  if (count < k) return -1;
  std::nth_element(all, all + (k - 1), all + count, [](float a, float b) { return a > b; });
  return all[k - 1];
}

// Evaluates the listed tiles; returns the maximum relative gain, or with care the maximum lower bound of one.
float Screening::evaluate(const std::uint32_t* list, std::size_t count) noexcept {
  const simd::Form form = tiles_.form();
  if (errors_.with_care()) {
    return kernel_.screen_with_care[form](tiles_.tiles(), w_, list, count, memory_.relative_gains, memory_.highest,
                                          memory_.lower);
  }
  return kernel_.screen[form](tiles_.tiles(), w_, list, count, memory_.relative_gains, memory_.highest);
}

void Screening::evaluate_listed() noexcept {
  float best[threading::Team::max_chunks];
  const std::uint32_t chunks = evaluator_.team().in_chunks(
      listed_, Evaluator::min_tiles, 1, [&](std::size_t first, std::size_t count, std::uint32_t chunk) {
        best[chunk] = evaluate(memory_.list + first, count);
      });
  learn_from(*std::max_element(best, best + chunks));
}

// Evaluates every tile of at least this stale bound that is not listed yet.
void Screening::evaluate_down_to(float min_bound) noexcept {
  evaluate_between(min_bound, listed_ == 0 ? float_infinity : simd::next_below(lowest_listed_));
  lowest_listed_ = min_bound;
}

// Lists and evaluates those tiles of every `chunks`-th run of 16, from run `chunk` on, whose stale bound is in this
// range.
simd::ScreenedTiles Screening::screen_between(float min_bound, float max_bound, std::uint32_t chunk,
                                              std::uint32_t chunks, std::uint32_t* list) noexcept {
  const std::size_t tile_count = tiles_.tile_count();
  if (errors_.with_care()) {
    const std::size_t count =
        kernel_.list_between(memory_.bounds, tile_count, chunk, chunks, min_bound, max_bound, list);
    return {count, evaluate(list, count)};
  }
  return kernel_.screen_between[tiles_.form()](tiles_.tiles(), w_, memory_.bounds, tile_count, chunk, chunks, min_bound,
                                               max_bound, list, memory_.relative_gains, memory_.highest);
}

// Evaluates the tiles whose stale bound is in this range. Chunks are strided because promising tiles are adjacent.
void Screening::evaluate_between(float min_bound, float max_bound) noexcept {
  simd::ScreenedTiles parts[threading::Team::max_chunks];
  std::size_t evaluations[threading::Team::max_chunks];
  constexpr std::size_t min_tiles = 256;  // per chunk: most of them are not evaluated
  const std::size_t tile_count = tiles_.tile_count();
  const std::uint32_t chunks = evaluator_.team().chunks_of(tile_count, min_tiles);
  const std::size_t runs = (tile_count + tile_size - 1) / tile_size;
  const std::size_t room = chunks == 1 ? 0 : (runs / chunks + 2) * tile_size;  // in the list, for each chunk
  lists_all_ = false;
  std::uint32_t* const list = memory_.list + listed_;
  evaluator_.team().for_chunks(chunks, [&](std::uint32_t chunk) {
    std::uint32_t* const own = list + room * chunk;
    parts[chunk] = screen_between(min_bound, max_bound, chunk, chunks, own);
    evaluations[chunk] = tiles_.remaining_in(own, parts[chunk].count);
  });
  std::size_t count = 0;
  float best = -1;
  for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
    const simd::ScreenedTiles& part = parts[chunk];
    if (chunk > 0) std::copy_n(list + room * chunk, part.count, list + count);
    count += part.count;
    evaluations_ += evaluations[chunk];
    best = std::max(best, part.largest);
  }
  listed_ += count;
  if (count > 0) learn_from(best);
}

// A whole round in one call of the kernel; returns false if the round has to go on.
bool Screening::evaluate_at_once(float first_threshold) noexcept {
  simd::PromisingRound round{};
  round.tile_count = tiles_.tile_count();
  round.first_threshold = first_threshold;
  round.line = errors_.line();
  round.tight_above = errors_.tight_above();
  round.tight_below = errors_.tight_below();
  round.drift = errors_.drift();
  round.bounds = memory_.bounds;
  round.relative_gains = memory_.relative_gains;
  round.highest = memory_.highest;
  round.list = memory_.list;
  round.lanes = memory_.survivors;
  lists_all_ = false;
  kernel_.screen_promising[tiles_.form()](tiles_.tiles(), w_, round);
  listed_ = round.listed;
  lowest_listed_ = round.lowest_listed;
  evaluations_ += tiles_.remaining_in(round.list, round.listed);
  learn_from(round.best);
  if (!round.is_done) return false;
  next_highest_bound_ = round.highest_bound;
  survivors_found_ = round.survivors;
  are_bounds_kept_ = true;
  return true;
}

}  // namespace maxlogdet
