// SPDX-License-Identifier: MIT
#include "kernel/screening/screening.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace maxlogdet {

using simd::any_candidate;
using simd::tile_size;

namespace {

// With more survivors than this, what may hold the best is evaluated again in float64.
constexpr std::size_t many_survivors = 24;
// The minimum number of tiles for a thread: about a microsecond of work, in float32 and in float64.
constexpr std::size_t min_tiles = 128;
constexpr std::size_t min_exact_tiles = 8;

}  // namespace

Screening::Screening(std::size_t capacity, threading::Team& team)
    : team_(team),
      tiles_(capacity),
      bounds_(padded(tiles_of(capacity))),
      highest_(padded(tiles_of(capacity))),
      gains_(padded(capacity)),
      list_(padded(tiles_of(capacity))) {}

void Screening::start(const Candidates& candidates) noexcept {
  candidates_ = &candidates;
  tiles_.start(candidates);
  errors_ = ErrorBounds(candidates.form, candidates.largest_of_form);
  round_ = simd::Round();
  round_.arrays = {bounds_.data(), highest_.data(), gains_.data(), list_};
  evaluations_ = 0;
  expected_share_ = 0.9;
}

void Screening::use_store(const unsigned char* free) noexcept {
  tiles_.use_store(free);
  forget();
}

void Screening::use_listed(const Index* listed, std::size_t count) noexcept {
  tiles_.use_listed(listed, count);
  forget();
}

void Screening::forget() noexcept {
  errors_.forget();
  float* const bounds = bounds_.data();
  std::fill_n(bounds, tiles_.tiles().count, float_infinity);
  std::fill(bounds + tiles_.tiles().count, bounds + tile_size * tiles_of(tiles_.tiles().count), -1.0F);
  highest_bound_ = float_infinity;
}

void Screening::order_by_gain() noexcept {
  assert(round_.evaluated_from <= any_candidate);  // all are evaluated
  const float top = std::max(0.0F, candidates_->kernel->arrays.largest(gains_.data(), tiles_.lanes()));
  const simd::TileLine line = round_.filter.line_of_tiles();
  tiles_.order_by(gains_.data(), top);
  float* const bounds = bounds_.data();
  const std::size_t count = tiles_.tiles().count;
  for (std::size_t tile = 0; tile < count; ++tile)
    bounds[tile] = line.at(tiles_.upper_end(static_cast<Tile>(tile), top));
  std::fill(bounds + count, bounds + tile_size * tiles_of(count), -1.0F);
  highest_bound_ = candidates_->kernel->arrays.largest(bounds, count);
}

void Screening::reset_round() noexcept {
  round_.evaluated_from = simd::nothing_evaluated;
  round_.assured = -1;
  best_ = -1;
}

void Screening::begin_round() noexcept {
  // A share of the highest bound slightly below that expected of the best relative gain: in two rounds of three no
  // other tile is needed. Whatever is missed is evaluated afterwards.
  share_ = static_cast<float>(std::max(0.25, 1.25 * expected_share_ - 0.25));
  const bool is_known = highest_bound_ < float_infinity;
  guess_ = !tiles_.is_ordered() ? any_candidate : is_known ? share_ * highest_bound_ : float_infinity;
  reset_round();
  const double expected = is_known ? expected_share_ * static_cast<double>(highest_bound_) : 0;
  errors_.begin_round(*factor_, tiles_.is_ordered(), highest_bound_, expected, round_.filter);
}

// The one loop of a selection that threads share: evaluates the tiles listed. Promising tiles are adjacent in the list
// as in the order, so that each thread has its share of them.
simd::Evaluated Screening::evaluate(const Tile* list, std::size_t count) noexcept {
  const bool in_float64 = errors_.in_float64();
  simd::Evaluated parts[threading::Team::max_chunks];
  // Runs on helpers: writes `gains` and `highest` of its own tiles, and its own part.
  const std::uint32_t chunks = team_.in_chunks(
      count, in_float64 ? min_exact_tiles : min_tiles, [&](std::size_t first, std::size_t size, std::uint32_t chunk) {
        parts[chunk] = in_float64 ? candidates_->exact().evaluate(tiles_.tiles(), tiles_.blocks(), factor_->inverse(),
                                                                  list + first, size, round_.arrays)
                                  : candidates_->kernel->evaluate[candidates_->form](
                                        tiles_.tiles(), factor_->narrow_inverse(), list + first, size, round_.arrays);
      });
  simd::Evaluated all = parts[0];
  for (std::uint32_t chunk = 1; chunk < chunks; ++chunk) {
    all.best = std::max(all.best, parts[chunk].best);
    all.count += parts[chunk].count;
  }
  return all;
}

// Evaluates until no tile that is left out may hold the best.
void Screening::prove_best() noexcept {
  const simd::RoundArrays& arrays = round_.arrays;
  float needed = guess_;
  while (!(needed >= round_.evaluated_from)) {  // at first nothing is evaluated, which is NaN
    const std::size_t count = candidates_->kernel->arrays.list_tiles(arrays.bounds, tiles_.tiles().count, needed,
                                                                     round_.evaluated_from, arrays.list);
    const simd::Evaluated found = evaluate(arrays.list, count);
    round_.evaluated_from = needed;
    evaluations_ += found.count;
    best_ = std::max(best_, std::min(found.best, std::numeric_limits<float>::max()));
    if (best_ < 0) {
      needed = share_ * candidates_->kernel->arrays.highest_unevaluated(tiles_.tiles(), round_);
      continue;
    }
    round_.filter.follow(best_);
    round_.assured = round_.filter.at_least(best_);
    needed = simd::stale_threshold(round_.assured, errors_.drift());
  }
}

std::size_t Screening::survivors(const InformationFactor& factor, Lane* lanes) noexcept {
  factor_ = &factor;
  begin_round();
  const std::size_t found = find_survivors(lanes);
  if (!tiles_.is_ordered()) return found;
  if (best_ > 0 && highest_bound_ > 0 && highest_bound_ < float_infinity) {
    // The next round should start as low.
    const double share = std::min(1.0, static_cast<double>(best_) / static_cast<double>(highest_bound_));
    expected_share_ += 0.5 * (share - expected_share_);
  }
  keep_bounds();
  return found;
}

std::size_t Screening::find_survivors(Lane* lanes) noexcept {
  const auto list = [&] { return candidates_->kernel->arrays.list_survivors(tiles_.tiles(), round_, lanes); };
  prove_best();
  const std::size_t found = list();
  if (found <= many_survivors || errors_.in_float64()) return found;
  const std::size_t evaluations = evaluations_;
  use_float64();
  prove_best();
  evaluations_ = evaluations;  // the same candidates count once
  return list();
}

// Called where one bound for all candidates excludes too few of them: what it has excluded stays so.
void Screening::use_float64() noexcept {
  if (tiles_.is_ordered()) keep_bounds();
  guess_ = tiles_.is_ordered() ? simd::stale_threshold(round_.assured, 0) : any_candidate;
  errors_.use_float64(round_.filter);
  reset_round();
}

void Screening::keep_bounds() noexcept {
  highest_bound_ = candidates_->kernel->arrays.keep_bounds(tiles_.tiles(), round_);
}

}  // namespace maxlogdet
