// SPDX-License-Identifier: MIT
#include "kernel/screening/screening.hpp"

#include "kernel/blocks/stored_rows.hpp"
#include "kernel/screening/lane_order.hpp"
#include "kernel/screening/steps.hpp"

#include <algorithm>
#include <cassert>

namespace maxlogdet {

using simd::any_candidate;
using simd::tile_size;

namespace {

// With more survivors than this, copies dropped, what may hold the best is evaluated again in float64.
constexpr std::size_t many_survivors = 24;

}  // namespace

ScreeningMemory::ScreeningMemory(std::size_t capacity)
    : tiles(capacity),
      bounds(padded(tiles_of(capacity))),
      highest(padded(tiles_of(capacity))),
      gains(padded(capacity)),
      list(padded(tiles_of(capacity)) + 2 * tile_size * threading::Team::max_chunks),
      ranked(padded(capacity)) {}

Screening::Screening(const Evaluator& evaluator, simd::Form form, const double* column_max,
                     ScreeningMemory& memory) noexcept
    : evaluator_(evaluator),
      kernel_(evaluator.kernel()),
      column_max_(column_max),
      memory_(memory),
      tiles_(evaluator, form, memory.tiles),
      errors_(form, column_max) {
  round_.arrays = {memory.bounds.data(), memory.highest.data(), memory.gains.data(), memory.list};
}

void Screening::use_store(const unsigned char* free, std::size_t n) noexcept {
  tiles_.use_store(free, n);
  errors_.set_column_max(column_max_);
  forget();
}

void Screening::use_listed(const Candidate* candidates, std::size_t count) noexcept {
  tiles_.use_listed(candidates, count);
  errors_.set_column_max(column_max_);
  forget();
}

void Screening::forget() noexcept {
  assert(!is_open_);
  errors_.forget();
  float* const bounds = memory_.bounds.data();
  std::fill_n(bounds, tiles_.tiles().count, float_infinity);
  std::fill(bounds + tiles_.tiles().count, bounds + tile_size * tiles_of(tiles_.tiles().count), -1.0F);
  highest_bound_ = float_infinity;
  last_norm_ = infinity;
}

void Screening::order_by_gain() noexcept {
  assert(!is_open_ && round_.evaluated_from <= any_candidate);  // all are evaluated
  const float top = std::max(0.0F, kernel_.arrays.largest(memory_.gains.data(), tiles_.lanes()));
  const simd::TileLine line = round_.filter.line_of_tiles();
  // The highest gain of a tile is below the upper end of its first lane's bucket.
  tiles_.order_by(memory_.gains.data(), top, [&](Tile tile, std::uint32_t bucket) {
    const std::int32_t below = static_cast<std::int32_t>(bucket) * (1 << lane_order_shift);
    memory_.bounds[tile] = line.at(float_of(bits_of(top) - below));
  });
  float* const bounds = memory_.bounds.data();
  const std::size_t count = tiles_.tiles().count;
  std::fill(bounds + count, bounds + tile_size * tiles_of(count), -1.0F);
  highest_bound_ = kernel_.arrays.largest(bounds, count);
  if (!errors_.is_small()) tiles_.find_column_max(errors_.column_max());
}

void Screening::begin(const InformationFactor& factor, float highest, float guess) noexcept {
  assert(!is_open_);
  is_open_ = true;
  factor_ = &factor;
  round_.guess = guess;
  reset_round();
  const double expected = highest < float_infinity ? expected_share_ * static_cast<double>(highest) : 0;
  errors_.begin_round(factor, tiles_.is_ordered(), highest, expected, round_);
}

// Nothing is evaluated yet.
void Screening::reset_round() noexcept {
  round_.evaluated_from = simd::nothing_evaluated;
  round_.best = -1;
  round_.assured = -1;
}

void Screening::begin_round(const InformationFactor& factor) noexcept {
#ifndef NDEBUG  // while information only increases, |W|^2 = tr M^-1 only decreases
  const double norm = factor.inverse_norm();
  assert(!tiles_.is_ordered() || norm <= last_norm_ * (1 + 1e-6));
  last_norm_ = norm;
#endif
  // A share of the highest bound slightly below that expected of the best relative gain: in two rounds of three no
  // other tile is needed.
  round_.share = static_cast<float>(std::max(0.25, 1.25 * expected_share_ - 0.25));
  begin(factor, highest_bound_, first_guess());
}

// Where to begin: about speed alone, as whatever is missed is evaluated afterwards.
float Screening::first_guess() const noexcept {
  if (!tiles_.is_ordered()) return any_candidate;
  return highest_bound_ < float_infinity ? round_.share * highest_bound_ : float_infinity;
}

bool Screening::is_inlined(std::size_t k) const noexcept {
  return k == 1 && !round_.has_evaluated() && !errors_.in_float64() && evaluator_.team().workers() == 1;
}

// Evaluates what may be among the k best, and lists what survives.
std::size_t Screening::find(std::size_t k, Lane* lanes) noexcept {
  if (is_inlined(k)) return kernel_.rounds[tiles_.form()].run(tiles_.tiles(), factor_->narrow_inverse(), round_, lanes);
  CalledSteps steps(evaluator_, tiles_, errors_, memory_, *factor_, k, round_.has_evaluated());
  simd::prove_best(round_, steps);
  return kernel_.bounds.list_survivors(tiles_.tiles(), round_, lanes);
}

std::size_t Screening::survivors(std::size_t k, Lane* lanes) noexcept {
  assert(is_open_);
  std::size_t found = find(k, lanes);
  if (k > 1 || found <= many_survivors) return found;
  found = drop_copies(lanes, found);
  if (found <= many_survivors || errors_.in_float64()) return found;
  const std::size_t evaluations = round_.evaluations;
  use_float64();
  found = find(k, lanes);
  round_.evaluations = evaluations;  // the same candidates count once
  return drop_copies(lanes, found);
}

// Of identical candidates only the one of lowest index can be selected: drops the copies of the survivor of lowest
// index.
std::size_t Screening::drop_copies(Lane* lanes, std::size_t count) const noexcept {
  const auto has_lower_index = [this](Lane a, Lane b) { return tiles_.candidate(a) < tiles_.candidate(b); };
  const Lane first = *std::min_element(lanes, lanes + count, has_lower_index);
  const auto is_copy = [this, first](Lane lane) {
    return lane != first &&
           are_identical(evaluator_.planes(), evaluator_.rows(), tiles_.candidate(lane), tiles_.candidate(first));
  };
  return static_cast<std::size_t>(std::remove_if(lanes, lanes + count, is_copy) - lanes);
}

// Called where one bound for all candidates excludes too few of them: what it has excluded stays so.
void Screening::use_float64() noexcept {
  if (tiles_.is_ordered()) keep_bounds();
  round_.guess = tiles_.is_ordered() ? simd::stale_threshold(round_.assured, 0) : any_candidate;
  errors_.use_float64(round_);
  reset_round();
}

void Screening::keep_bounds() noexcept { highest_bound_ = kernel_.bounds.keep(tiles_.tiles(), round_); }

void Screening::end_round() noexcept {
  assert(is_open_);
  is_open_ = false;
  if (!tiles_.is_ordered()) return;
  if (round_.best > 0 && highest_bound_ > 0 && highest_bound_ < float_infinity) {
    // After removals the best is that of the remaining candidates: the next round should start as low.
    const double found = std::min(1.0, static_cast<double>(round_.best) / static_cast<double>(highest_bound_));
    expected_share_ += 0.5 * (found - expected_share_);
  }
  keep_bounds();
}

float Screening::bound_all(const InformationFactor& factor) noexcept {
  begin(factor, float_infinity, any_candidate);
  CalledSteps steps(evaluator_, tiles_, errors_, memory_, *factor_, 1, false);
  simd::prove_best(round_, steps);
  keep_bounds();
  is_open_ = false;
  return highest_bound_;
}

std::size_t Screening::try_at(const InformationFactor& factor, float min_bound, Lane* lanes) noexcept {
  errors_.forget();  // of the factor of the rounds before
  begin(factor, float_infinity, std::max(any_candidate, min_bound));
  std::size_t found = try_guess(lanes);
  if (found > many_survivors && !errors_.in_float64()) {
    errors_.use_float64(round_);
    reset_round();
    found = try_guess(lanes);
  }
  is_open_ = false;
  errors_.forget();  // of this factor
  return found;
}

// Evaluates down to the guess, and no further.
std::size_t Screening::try_guess(Lane* lanes) noexcept {
  CalledSteps steps(evaluator_, tiles_, errors_, memory_, *factor_, 1, false);
  round_.evaluated_from = steps.evaluate(round_, round_.guess);
  round_.learn(steps.best(round_));
  const std::size_t found = kernel_.bounds.list_survivors(tiles_.tiles(), round_, lanes);
  return found > many_survivors ? drop_copies(lanes, found) : found;
}

void Screening::remove(Lane lane) noexcept {
  tiles_.remove(lane);
  memory_.gains[lane] = -1;
  if (is_open_) {
    const Tile tile = simd::tile_of(lane);
    memory_.highest[tile] = kernel_.arrays.largest(memory_.gains.data() + simd::first_lane(tile), tile_size);
    return;
  }
  // A far outlier of a frame is selected early; it should not loosen error bounds any longer.
  if (!tiles_.is_ordered() || errors_.is_small()) return;
  tiles_.clear_entries(lane);
  tiles_.find_column_max(errors_.column_max());
}

}  // namespace maxlogdet
