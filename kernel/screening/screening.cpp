// SPDX-License-Identifier: MIT
#include "kernel/screening/screening.hpp"

#include "kernel/screening/lane_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet {
namespace {

using simd::any_candidate;
using simd::rounded_down;
using simd::rounded_up;
using simd::tile_size;

constexpr double unit_roundoff = std::numeric_limits<float>::epsilon() / 2;
// Rounding errors in units of 2^-24, see docs/numerics.md: of a row of Y, and of the sum of minors for 1, 2 and 3 rows.
constexpr double whitening_errors[simd::forms] = {8, 8, 8, 12};
constexpr double minors_errors[] = {8, 32, 160};
// |Y| within which no float32 operation of the kernels overflows, or loses what it should not to underflow.
constexpr double largest_norm = 1e6;
constexpr double smallest_norm = 1e-15;
// An error of sqrt(det) below which one bound for all candidates is as good as one for each.
constexpr double small_volume_error = 1e-3;
// More survivors than this are looked at again with care before float64 has to decide.
constexpr std::size_t many_survivors = 24;
// A tangent of sqrt(1 + relative gain) is tight up to that factor of 1 + relative gain.
constexpr double far_from_tangent = 4;
// Bounds of the error are taken anew when no relative gain is above this share of the highest one then.
constexpr float outdated = 0.75F;

// Room for whole tiles, and for whole vectors of values per tile.
std::size_t lanes_for(std::size_t count) noexcept { return tile_size * (tiles_of(count) + 1); }

}  // namespace

ScreeningMemory::ScreeningMemory(std::size_t capacity)
    : records(lanes_for(capacity) * simd::record_size(simd::three_rows)),
      packed(lanes_for(capacity) * simd::dimension * max_block_rows),
      candidate(lanes_for(capacity)),
      remaining(lanes_for(capacity)),
      relative_gains(lanes_for(capacity)),
      lower(lanes_for(capacity)),
      values(lanes_for(capacity)),
      bucket(lanes_for(capacity)),
      order_counts(lane_order_counts),
      highest(lanes_for(tiles_of(capacity))),
      bounds(lanes_for(tiles_of(capacity))),
      list(2 * lanes_for(tiles_of(capacity)) + 2 * tile_size * threading::Team::max_chunks),
      tile_remaining(tiles_of(capacity)),
      lane(lanes_for(capacity)) {}

void Screening::use_store(const unsigned char* free, std::size_t n) noexcept {
  lists_all_ = false;
  remaining_ = 0;
  is_store_order_ = true;
  is_ordered_ = false;
  tile_count_ = tiles_of(n);
  tiles_ = {evaluator_.planes().data, tile_size, evaluator_.planes().stride, memory_.remaining};
  if (form_ == simd::factored) {
    evaluator_.pack(form_, n, memory_.packed);
    tiles_ = {memory_.packed, tile_size * simd::entries_of(form_), tile_size, memory_.remaining};
  }
  for (std::size_t i = 0; i < n; ++i) memory_.remaining[i] = free[i] != 0 ? 1.0F : 0.0F;
  std::fill(memory_.remaining + n, memory_.remaining + lanes(), 0.0F);
  for (std::size_t tile = 0; tile < tile_count_; ++tile) {
    unsigned count = 0;  // converted, not compared: GCC 12 adds up comparisons of floats on AArch64 as -1 each
    for (std::size_t lane = 0; lane < tile_size; ++lane)
      count += static_cast<unsigned>(static_cast<int>(memory_.remaining[tile_size * tile + lane]));
    memory_.tile_remaining[tile] = static_cast<unsigned char>(count);
    remaining_ += count;
  }
}

void Screening::make_records(std::size_t n) noexcept { evaluator_.make_records(form_, n, memory_.records); }

void Screening::make_records_of(const std::uint32_t* candidates, std::size_t count) noexcept {
  std::size_t done = 0;  // candidates below it have records
  for (std::size_t j = 0; j < count; ++j) {
    if (candidates[j] < done) continue;
    const std::size_t first = candidates[j] / tile_size * tile_size;
    const simd::Planes planes{evaluator_.planes().data + first, evaluator_.planes().stride};
    kernel_.make_records[form_](planes, tile_size, memory_.records + first * simd::record_size(form_));
    done = first + tile_size;
  }
}

void Screening::restart(const double* column_max) noexcept {
  std::copy_n(column_max, simd::dimension, column_max_);
  with_care_ = false;
  is_lasting_ = false;
}

simd::Tiles pack_listed(const threading::Evaluator& evaluator, simd::Form form, std::size_t count,
                        ScreeningMemory& memory) noexcept {
  const std::size_t lanes = tile_size * tiles_of(count);
  std::uint32_t* const candidate = memory.candidate;
  float* const remaining = memory.remaining;
  if (count < lanes) std::fill(candidate + count, candidate + lanes, candidate[count - 1]);
  std::fill_n(remaining, count, 1.0F);
  std::fill(remaining + count, remaining + lanes, 0.0F);
  evaluator.gather(form, memory.records, candidate, lanes, memory.packed);
  return {memory.packed, tile_size * simd::entries_of(form), tile_size, remaining};
}

void Screening::use_listed(const std::uint32_t* candidates, std::size_t count) noexcept {
  lists_all_ = false;
  remaining_ = count;
  is_store_order_ = false;
  is_ordered_ = false;
  tile_count_ = tiles_of(count);
  if (candidates != memory_.candidate) std::copy_n(candidates, count, static_cast<std::uint32_t*>(memory_.candidate));
  tiles_ = pack_listed(evaluator_, form_, count, memory_);
  std::fill_n(static_cast<unsigned char*>(memory_.tile_remaining), tile_count_, static_cast<unsigned char>(tile_size));
  const std::size_t filling = lanes() - count;
  if (filling > 0) memory_.tile_remaining[tile_count_ - 1] = static_cast<unsigned char>(tile_size - filling);
}

void Screening::order_by_gain(bool find_lanes) noexcept {
  const std::size_t lanes = this->lanes();
  const float top = std::max(0.0F, kernel_.largest(memory_.relative_gains, lanes));
  // Lanes are candidates in the order of the store; else `lane` is scratch until it is filled below.
  std::uint32_t* const order = is_store_order_ ? memory_.candidate : memory_.lane;
  const std::size_t count = order_lanes(memory_.relative_gains, memory_.remaining, lanes, top, evaluator_.team(),
                                        memory_.order_counts, memory_.bucket, order);
  slope_ = all_slope_;
  offset_ = all_offset_;
  const Line line = upper_line();
  for (std::size_t tile = 0; tile < tiles_of(count); ++tile) {
    // Of the first lane's bucket, the highest in the tile, the upper end.
    const auto below = static_cast<std::int32_t>(memory_.bucket[order[tile * tile_size]]);
    memory_.bounds[tile] = line.at(float_of(bits_of(top) - below * (1 << lane_order_shift)));
  }

  if (is_store_order_) {
    make_records(lanes);
  } else {
    for (std::size_t lane = 0; lane < count; ++lane) order[lane] = memory_.candidate[order[lane]];
  }
  use_listed(order, count);
  highest_bound_ = kernel_.largest(memory_.bounds, tile_count_);
  is_ordered_ = true;
  for (std::size_t lane = 0; find_lanes && lane < count; ++lane) {
    memory_.lane[memory_.candidate[lane]] = static_cast<std::uint32_t>(lane);
  }
  if (volume_error_ > small_volume_error) kernel_.column_max[form_](memory_.packed, tile_count_, column_max_);
}

void Screening::begin_round(const InformationFactor& factor) noexcept {
  listed_ = 0;
  survivors_found_ = 0;
  are_bounds_kept_ = false;
  best_ = -1;
  assured_ = -1;
  w64_ = factor.inverse();
  w_ = factor.narrow_inverse();
  const double f = factor.relative_error();
  factor_drift_ = f < hopeless_error ? 2.5 * rows_ * f : std::numeric_limits<double>::infinity();
  // Once the error is small its bound may be a wide one, of an earlier round.
  const bool may_last = is_ordered_ && !with_care_ && volume_error_ <= small_volume_error && factor_drift_ < 1e-3;
  const bool is_outdated = highest_bound_ < outdated * bounded_highest_ || factor_drift_ > bounded_drift_;
  is_bounded_anew_ = !(may_last && is_lasting_) || is_outdated;
  if (!is_bounded_anew_) return;
  is_lasting_ = may_last;
  bound_errors();
}

void Screening::bound_errors() noexcept {
  constexpr int n = InformationFactor::n;
  double squares = 0;  // of | |W| |h| | for the row h whose entries are the largest of their columns
  double frobenius = 0;
  for (int c = 0; c < n; ++c) {
    const double* const w = w64_ + static_cast<std::size_t>(simd::padded_dimension * c);
    double sums[2] = {0, 0};
    for (int d = 0; d <= c; ++d) {
      constexpr double floor = simd::smallest_entry;
      sums[d % 2] += std::max(std::abs(w[d]), floor) * column_max_[d];
      frobenius += (w[d] * w[d] + floor * floor) * (column_max_[d] * column_max_[d]);
    }
    squares += (sums[0] + sums[1]) * (sums[0] + sums[1]);
  }
  // Six times |W D|^2, D the column maxima, is above that, and can only fall from here on.
  whitened_squares_ = is_lasting_ ? n * frobenius : squares;
  const double norm = std::sqrt(whitened_squares_);
  delta_ = whitening_errors[form_] * unit_roundoff * norm;
  bound_volumes(whitened_squares_);

  const bool overflows = !(norm < largest_norm) || !(norm > smallest_norm);
  // Three long rows are hardly ever far from parallel.
  const bool is_hopeless = rows_ == 3 && volume_error_ > 1;
  with_care_ = overflows || is_hopeless || (with_care_ && volume_error_ > small_volume_error);
}

// With no row of Y longer than the root of `squares`.
void Screening::bound_volumes(double squares) noexcept {
  const double length = std::sqrt(1 + squares) + delta_;
  shrink_ = std::min(1.0, std::sqrt(squares));
  volume_error_ = rows_ * delta_;
  double relative_gain = squares;  // (1 + squares)^rows - 1, without cancellation
  for (int row = 1; row < rows_; ++row) {
    volume_error_ *= length;
    relative_gain += squares + relative_gain * squares;
  }
  minors_error_ = minors_errors[rows_ - 1] * unit_roundoff * relative_gain + 1e-36;
}

// |relative gain - exact| <= minors error + 2 sqrt(1 + relative gain) error + error^2, by a tangent of the square root:
// tight near this relative gain, true for all.
void Screening::bound_errors_near(double relative_gain) noexcept {
  if (with_care_) {  // relative gains are bounds themselves
    slope_ = 1;
    offset_ = 0;
    return;
  }
  tangent_ = relative_gain;
  const double root = std::sqrt(1 + relative_gain);
  const double error = volume_error_ * shrink_;
  slope_ = 1 + error / root;
  offset_ = error * (root + 1 / root) + volume_error_ * volume_error_ + minors_error_;
}

Screening::Line Screening::upper_line() const noexcept {
  constexpr double room = 1 + 1e-6;  // for the rounding of the line and of its values
  return {rounded_up(slope_ * room), rounded_up(offset_)};
}

void Screening::keep_bounds() noexcept {
  const Line line = upper_line();
  const std::uint32_t* const list = memory_.list;
  const float* const highest = memory_.highest;
  float* const bounds = memory_.bounds;
  for (std::size_t j = 0; j < listed_; ++j) bounds[list[j]] = line.at(highest[list[j]]);
  next_highest_bound_ = kernel_.largest(memory_.bounds, tile_count_);
  are_bounds_kept_ = true;
}

void Screening::end_round() noexcept {
  if (!are_bounds_kept_) keep_bounds();
  if (best_ > 0 && highest_bound_ > 0 && highest_bound_ < std::numeric_limits<float>::infinity()) {
    // After rejections, of the best that was left: as far the next round had better look at once.
    const double found = std::min(1.0, static_cast<double>(best_) / static_cast<double>(highest_bound_));
    expected_share_ += 0.5 * (found - expected_share_);
  }
  highest_bound_ = next_highest_bound_;
}

// Of the tiles listed, the largest relative gain, or with care the largest lower bound of one.
float Screening::evaluate(const std::uint32_t* list, std::size_t count) noexcept {
  if (with_care_) {
    return kernel_.screen_with_care[form_](tiles_, w_, list, count, memory_.relative_gains, memory_.highest,
                                           memory_.lower);
  }
  return kernel_.screen[form_](tiles_, w_, list, count, memory_.relative_gains, memory_.highest);
}

// What `best`, found by evaluate, tells about all candidates.
void Screening::learn_from(float best) noexcept {
  best_ = std::max(best_, best);
  if (with_care_) assured_ = std::max(assured_, static_cast<double>(best));
  if (with_care_ || best_ < 0) return;
  const auto relative_gain = static_cast<double>(best_);
  const bool is_near =
      relative_gain > (1 + tangent_) / far_from_tangent - 1 && relative_gain < (1 + tangent_) * far_from_tangent - 1;
  if (!is_near) bound_errors_near(relative_gain);
  assured_ = std::max(assured_, relative_gain - ((slope_ - 1) * relative_gain + offset_));
}

std::size_t Screening::remaining_in(const std::uint32_t* list, std::size_t count) const noexcept {
  std::size_t sum = 0;
  for (std::size_t j = 0; j < count; ++j) sum += memory_.tile_remaining[list[j]];
  return sum;
}

void Screening::evaluate_all() noexcept {
  if (!lists_all_) {
    for (std::size_t tile = 0; tile < tile_count_; ++tile) memory_.list[tile] = static_cast<std::uint32_t>(tile);
    lists_all_ = true;
  }
  listed_ = tile_count_;
  lowest_listed_ = -std::numeric_limits<float>::infinity();
  bound_errors_near(0);
  evaluate_listed();
  all_slope_ = slope_;
  all_offset_ = offset_;
  evaluations_ += remaining_;
}

// The tiles listed.
void Screening::evaluate_listed() noexcept {
  float best[threading::Team::max_chunks];
  const std::uint32_t chunks = evaluator_.team().in_chunks(
      listed_, threading::Evaluator::min_tiles, 1, [&](std::size_t first, std::size_t count, std::uint32_t chunk) {
        best[chunk] = evaluate(memory_.list + first, count);
      });
  learn_from(*std::max_element(best, best + chunks));
}

void Screening::evaluate_trial(float least) noexcept {
  bound_errors_near(static_cast<double>(std::max(0.0F, least)));
  evaluate_between(std::max(0.0F, least), std::numeric_limits<float>::infinity());
}

// What a bound found earlier must reach for its tile to matter.
float Screening::stale_threshold() const noexcept {
  const double threshold = assured_ > 0 ? assured_ - (1 + assured_) * factor_drift_ : 0;
  return threshold > 0 ? rounded_down(threshold) : any_candidate;
}

// The tiles whose bound of an earlier round is in this range. A chunk takes every so many-th
// pack of tiles: promising ones lie together.
void Screening::evaluate_between(float least, float most) noexcept {
  struct Part {
    std::size_t count, evaluations;
    float best;
  };
  Part parts[threading::Team::max_chunks];
  constexpr std::size_t min_tiles = 256;  // of a chunk: most are not looked at
  const std::uint32_t chunks = evaluator_.team().chunks_of(tile_count_, min_tiles);
  const std::size_t packs = (tile_count_ + tile_size - 1) / tile_size;
  const std::size_t room = chunks == 1 ? 0 : (packs / chunks + 2) * tile_size;  // in the list, for each chunk
  lists_all_ = false;
  std::uint32_t* const list = memory_.list + listed_;
  evaluator_.team().for_chunks(chunks, [&](std::uint32_t chunk) {
    std::uint32_t* const own = list + room * chunk;
    Part& part = parts[chunk];
    if (with_care_) {
      part.count = kernel_.list_between(memory_.bounds, tile_count_, chunk, chunks, least, most, own);
      part.best = evaluate(own, part.count);
    } else {
      const simd::ScreenedTiles found =
          kernel_.screen_between[form_](tiles_, w_, memory_.bounds, tile_count_, chunk, chunks, least, most, own,
                                        memory_.relative_gains, memory_.highest);
      part.count = found.count;
      part.best = found.largest;
    }
    part.evaluations = remaining_in(own, part.count);
  });
  std::size_t count = 0;
  float best = -1;
  for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
    const Part& part = parts[chunk];
    if (chunk > 0) std::copy_n(list + room * chunk, part.count, list + count);
    count += part.count;
    evaluations_ += part.evaluations;
    best = std::max(best, part.best);
  }
  listed_ += count;
  if (count > 0) learn_from(best);
}

// Every tile of at least this bound, that is not listed yet.
void Screening::evaluate_down_to(float least) noexcept {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto just_below = [](float value) {
    return value > 0 ? float_of(bits_of(value) - 1) : std::nextafter(value, -infinity);
  };
  evaluate_between(least, listed_ == 0 ? infinity : just_below(lowest_listed_));
  lowest_listed_ = least;
}

// A relative gain, or with care a lower bound of one, that at least `wanted` candidates in the tiles listed reach;
// below 0 if there are fewer.
float Screening::best_listed(std::size_t wanted) noexcept {
  const float* const values = with_care_ ? memory_.lower : memory_.relative_gains;
  float* const all = memory_.values;
  std::size_t count = 0;
  if (wanted <= listed_) {  // as many tiles hold one each
    for (std::size_t j = 0; j < listed_; ++j) {
      const std::uint32_t tile = memory_.list[j];
      all[count++] = with_care_ ? kernel_.largest(values + tile_size * tile, tile_size) : memory_.highest[tile];
    }
  } else {
    for (std::size_t j = 0; j < listed_; ++j, count += tile_size) {
      std::copy_n(values + tile_size * memory_.list[j], tile_size, all + count);
    }
  }
  if (wanted == 1) return count == 0 ? -1.0F : *std::max_element(all, all + count);
  if (count < wanted) return -1;
  std::nth_element(all, all + (wanted - 1), all + count, [](float a, float b) { return a > b; });
  return all[wanted - 1];
}

void Screening::look_again(std::size_t wanted) noexcept {
  best_ = -1;
  assured_ = -1;
  learn_from(best_listed(wanted));
}

// Of the highest bound, a bit below what the best is expected to reach: in two rounds of three no other tile matters
// then.
float Screening::share_of_expected() const noexcept {
  return static_cast<float>(std::max(0.25, 1.25 * expected_share_ - 0.25));
}

float Screening::highest_unlisted() const noexcept {
  float highest = any_candidate;
  for (std::size_t tile = 0; tile < tile_count_; ++tile) {
    const float bound = memory_.bounds[tile];
    if (bound < lowest_listed_ && bound > highest) highest = bound;
  }
  return highest;
}

// The same in one call of the kernel, with all that belongs to a round; false if it has left something to do.
bool Screening::evaluate_at_once(float clearly) noexcept {
  simd::PromisingRound round{};
  round.tile_count = tile_count_;
  round.clearly = clearly;
  round.slope = slope_;
  round.offset = offset_;
  round.nearest = (1 + tangent_) / far_from_tangent - 1;
  round.farthest = (1 + tangent_) * far_from_tangent - 1;
  round.drift = factor_drift_;
  round.bounds = memory_.bounds;
  round.relative_gains = memory_.relative_gains;
  round.highest = memory_.highest;
  round.list = memory_.list;
  round.lanes = memory_.bucket;
  lists_all_ = false;
  kernel_.screen_promising[form_](tiles_, w_, round);
  listed_ = round.listed;
  lowest_listed_ = round.lowest_listed;
  evaluations_ += remaining_in(round.list, round.listed);
  learn_from(round.best);
  if (!round.is_done) return false;
  next_highest_bound_ = round.highest_bound;
  survivors_found_ = round.survivors;
  are_bounds_kept_ = true;
  return true;
}

void Screening::evaluate_promising(std::size_t wanted) noexcept {
  // Tiles whose bound is well above what the best is expected to reach, by how far it fell short of the highest bound
  // in earlier rounds: they are evaluated in any case. What they hold then decides about the others.
  const bool is_first_look = listed_ == 0;
  const auto highest = static_cast<double>(highest_bound_);
  if (is_first_look) {
    const bool is_known = highest < std::numeric_limits<double>::infinity();
    if (is_bounded_anew_) {
      // det(I + Y Y^T) - 1 >= |y|^2 for each row y of Y.
      bounded_drift_ = 2 * factor_drift_;
      bounded_highest_ = highest_bound_;
      const double squares = highest + (1 + highest) * bounded_drift_;
      if (is_known && !with_care_) {
        bound_volumes(std::min(whitened_squares_, 1.1 * std::max(0.0, squares) + 12 * delta_ * delta_));
      }
      bound_errors_near(is_known ? std::max(0.0, expected_share_ * highest) : 0);
    }
    const float clearly = is_known ? share_of_expected() * highest_bound_ : std::numeric_limits<float>::infinity();
    if (wanted == 1 && clearly > 0 && !with_care_ && !are_withdrawn_ && evaluator_.team().workers() == 1) {
      if (evaluate_at_once(clearly)) return;
    } else {
      evaluate_down_to(clearly);
    }
  }
  for (;;) {
    if (wanted > 1 || !is_first_look) look_again(wanted);
    // Where too few are left of what is listed, a step further down first.
    const float step = wanted == 1 ? share_of_expected() : 0.5F;
    const float threshold = best_ < 0 ? step * highest_unlisted() : stale_threshold();
    if (!(threshold < lowest_listed_)) break;
    // A little further than needed: the next rejection may need it.
    evaluate_down_to(is_first_look || threshold < 0 ? threshold : 0.98F * threshold);
  }
}

// What a relative gain must reach for its candidate to be perhaps the best.
float Screening::survivor_threshold() const noexcept {
  const double least = (assured_ - offset_) * std::max(0.0, 2 - slope_);  // 1 / slope is at least that
  return least > 0 ? rounded_down(least) : any_candidate;
}

std::size_t Screening::list_survivors(const float* unlike, std::uint32_t* lanes) const noexcept {
  const float threshold = survivor_threshold();
  const std::uint32_t* list = memory_.list;
  std::size_t count = listed_;
  if (lists_all_) {  // a look at 16 tiles at once
    std::uint32_t* const some = memory_.list + tile_count_;
    count = kernel_.list_between(memory_.highest, tile_count_, 0, 1, threshold, std::numeric_limits<float>::infinity(),
                                 some);
    list = some;
  }
  return kernel_.list_survivors[form_](tiles_, memory_.relative_gains, memory_.highest, threshold, list, count, unlike,
                                       lanes);
}

// Takes out of the list whatever is the same as `first`, entry for entry of its rows.
std::size_t Screening::drop_copies(std::uint32_t* lanes, std::size_t count, std::uint32_t first) const noexcept {
  const simd::Planes& planes = evaluator_.planes();
  const auto is_copy = [&](std::uint32_t lane) {
    for (std::size_t e = 0; e < std::size_t{simd::dimension} * static_cast<std::size_t>(rows_); ++e) {
      const float* const plane = planes.data + e * planes.stride;
      if (plane[candidate(lane)] < plane[candidate(first)] || plane[candidate(lane)] > plane[candidate(first)])
        return false;
    }
    return true;
  };
  return static_cast<std::size_t>(std::remove_if(lanes, lanes + count, is_copy) - lanes);
}

// Of candidates that are the same, entry for entry, only the first can be selected: of all those that are the same as
// the first survivor, only that one is left.
std::size_t Screening::list_distinct_survivors(std::uint32_t* lanes) const noexcept {
  std::size_t found = survivors_found_;
  if (found > 0) {
    std::copy_n(static_cast<const std::uint32_t*>(memory_.bucket), found, lanes);
  } else {
    found = list_survivors(nullptr, lanes);
  }
  if (found <= many_survivors) return found;
  std::uint32_t first = lanes[0];
  std::uint32_t least = candidate(first);
  for (std::size_t j = 1; j < found; ++j) {
    const std::uint32_t other = candidate(lanes[j]);
    first = other < least ? lanes[j] : first;
    least = std::min(least, other);
  }
  std::size_t others = 0;
  if (form_ == simd::factored) {
    others = drop_copies(lanes, found, first);
  } else {
    float of_first[simd::dimension * max_block_rows];
    for (std::size_t e = 0; e < simd::entries_of(form_); ++e) of_first[e] = entries(first)[e * tiles_.entry_stride];
    others = list_survivors(of_first, lanes);
  }
  lanes[others] = first;
  return others + 1;
}

// One bound for all candidates tells too few of them apart.
void Screening::look_with_care() noexcept {
  if (is_ordered_ && !are_withdrawn_ && !are_bounds_kept_) keep_bounds();  // of those that are not looked at again, too
  are_bounds_kept_ = false;
  survivors_found_ = 0;
  std::size_t kept = 0;
  for (std::size_t j = 0; j < listed_; ++j) {
    const std::uint32_t tile = memory_.list[j];
    const bool may_hold_best = slope_ * static_cast<double>(memory_.highest[tile]) + offset_ >= assured_;
    if (may_hold_best || are_withdrawn_) memory_.list[kept++] = tile;
  }
  lists_all_ = lists_all_ && kept == listed_;
  listed_ = kept;
  with_care_ = true;
  bound_errors_near(0);
  evaluate_listed();
}

std::size_t Screening::survivors(std::uint32_t* lanes) noexcept {
  const std::size_t found = list_distinct_survivors(lanes);
  if (with_care_ || found <= many_survivors) return found;
  look_with_care();
  return list_distinct_survivors(lanes);
}

std::size_t Screening::survivors(std::size_t wanted, std::uint32_t* lanes) noexcept {
  return wanted == 1 ? survivors(lanes) : list_survivors(nullptr, lanes);
}

std::size_t Screening::next_certain() noexcept {
  if (with_care_) return lanes();
  float best = -1;
  float second = -1;  // of the tiles' highest
  std::uint32_t tile = 0;
  for (std::size_t j = 0; j < listed_; ++j) {
    const float highest = memory_.highest[memory_.list[j]];
    tile = highest > best ? memory_.list[j] : tile;
    second = std::max(second, std::min(best, highest));
    best = std::max(best, highest);
  }
  if (best < 0) return lanes();
  best_ = -1;
  assured_ = -1;
  learn_from(best);
  const float threshold = survivor_threshold();
  if (second >= threshold || stale_threshold() < lowest_listed_) return lanes();
  std::uint32_t found[2 * tile_size];
  const std::size_t count = kernel_.list_survivors[form_](tiles_, memory_.relative_gains, memory_.highest, threshold,
                                                          &tile, 1, nullptr, found);
  return count == 1 ? found[0] : lanes();
}

void Screening::withdraw(std::size_t lane) noexcept {
  const std::size_t tile = lane / tile_size;
  memory_.remaining[lane] = 0;
  --remaining_;
  memory_.relative_gains[lane] = -1;
  memory_.lower[lane] = -1;
  --memory_.tile_remaining[tile];
  memory_.highest[tile] = kernel_.largest(memory_.relative_gains + tile_size * tile, tile_size);
}

void Screening::remove(std::size_t lane) noexcept {
  memory_.remaining[lane] = 0;
  --remaining_;
  memory_.relative_gains[lane] = -1;
  --memory_.tile_remaining[lane / tile_size];
  // A far outlier of a frame is selected early; error bounds should not suffer from it any longer than that.
  if (!is_ordered_ || volume_error_ <= small_volume_error) return;
  float* entry = memory_.packed + lane / tile_size * tiles_.tile_stride + lane % tile_size;
  for (std::size_t e = 0; e < simd::entries_of(form_); ++e, entry += tile_size) *entry = 0;
  kernel_.column_max[form_](memory_.packed, tile_count_, column_max_);
}

}  // namespace maxlogdet
