// SPDX-License-Identifier: MIT
#include "kernel/screening.hpp"

#include "kernel/lane_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet {
namespace {

using simd::tile_size;

constexpr double unit_roundoff = std::numeric_limits<float>::epsilon() / 2;
// Rounding errors in units of 2^-24, see docs/numerics.md: of a row of Y, and of the sum of minors for 1, 2 and 3 rows.
constexpr double whitening_errors = 8;
constexpr double minors_errors[] = {8, 32, 160};
// |Y| within which no float32 operation of the kernels overflows, or loses what it should not to underflow.
constexpr double largest_norm = 1e6;
constexpr double smallest_norm = 1e-15;
// An error of sqrt(det) below which one bound for all candidates is as good as one for each.
constexpr double small_volume_error = 1e-3;
// More survivors than this are looked at again with care before float64 has to decide.
constexpr std::size_t many_survivors = 24;
// Rounds for which one bound of the error has to do; not before as many have been.
constexpr std::uint32_t period = 8;
// Thresholds that must not let a lane through that has no candidate (growth -1).
constexpr float any_candidate = -0.5F;

// The next float32 at or beyond a bound, with room for the few roundings that lead to it.
float rounded_down(double value) noexcept { return static_cast<float>(value - std::abs(value) * 5e-7); }
float rounded_up(double value) noexcept { return static_cast<float>(value + std::abs(value) * 5e-7); }

// Room for whole tiles, and for whole vectors of values per tile.
std::size_t lanes_for(std::size_t count) noexcept { return tile_size * (tiles_of(count) + 1); }

}  // namespace

ScreeningMemory::ScreeningMemory(std::size_t capacity)
    : records(lanes_for(capacity) * simd::record_size(max_block_rows)),
      packed(lanes_for(capacity) * simd::dimension * max_block_rows),
      candidate(lanes_for(capacity)),
      remaining(lanes_for(capacity)),
      growths(lanes_for(capacity)),
      bucket(lanes_for(capacity)),
      order_counts(lane_order_counts),
      highest(lanes_for(tiles_of(capacity))),
      bounds(lanes_for(tiles_of(capacity))),
      list(2 * lanes_for(tiles_of(capacity)) + 2 * tile_size * threading::Team::most_chunks),
      tile_remaining(tiles_of(capacity)),
      lane(lanes_for(capacity)) {}

void Screening::use_store(const unsigned char* free, std::size_t n) noexcept {
  lists_all_ = false;
  remaining_ = 0;
  is_store_order_ = true;
  is_ordered_ = false;
  tile_count_ = tiles_of(n);
  tiles_ = {evaluator_.planes().data, tile_size, evaluator_.planes().stride, memory_.remaining};
  std::fill(memory_.remaining + n, memory_.remaining + lanes(), 0.0F);
  for (std::size_t tile = 0; tile < tile_count_; ++tile) {
    const std::size_t first = tile_size * tile;
    unsigned count = 0;
    for (std::size_t i = first; i < std::min(first + tile_size, n); ++i) {
      memory_.remaining[i] = free[i] != 0 ? 1.0F : 0.0F;
      count += free[i] != 0 ? 1 : 0;
    }
    memory_.tile_remaining[tile] = static_cast<unsigned char>(count);
    remaining_ += count;
  }
}

void Screening::make_records(std::size_t n) noexcept { evaluator_.make_records(n, memory_.records); }

void Screening::make_records_of(const std::uint32_t* candidates, std::size_t count) noexcept {
  std::size_t done = 0;  // candidates below it have records
  for (std::size_t j = 0; j < count; ++j) {
    if (candidates[j] < done) continue;
    const std::size_t first = candidates[j] / tile_size * tile_size;
    const simd::Planes planes{evaluator_.planes().data + first, evaluator_.planes().stride};
    kernel_.make_records[rows_ - 1](planes, tile_size, memory_.records + first * simd::record_size(rows_));
    done = first + tile_size;
  }
}

void Screening::restart(const double* column_max) noexcept {
  std::copy_n(column_max, simd::dimension, column_max_);
  now_ = 0;
  with_care_ = false;
  is_lasting_ = false;
}

simd::Tiles pack_listed(const threading::Evaluator& evaluator, std::size_t count, ScreeningMemory& memory) noexcept {
  const std::size_t lanes = tile_size * tiles_of(count);
  std::uint32_t* const candidate = memory.candidate;
  float* const remaining = memory.remaining;
  if (count < lanes) std::fill(candidate + count, candidate + lanes, candidate[count - 1]);
  std::fill_n(remaining, count, 1.0F);
  std::fill(remaining + count, remaining + lanes, 0.0F);
  evaluator.gather(memory.records, candidate, lanes, memory.packed);
  const std::size_t tile_floats = tile_size * simd::dimension * static_cast<std::size_t>(evaluator.rows());
  return {memory.packed, tile_floats, tile_size, remaining};
}

void Screening::use_listed(const std::uint32_t* candidates, std::size_t count) noexcept {
  lists_all_ = false;
  remaining_ = count;
  is_store_order_ = false;
  is_ordered_ = false;
  tile_count_ = tiles_of(count);
  if (candidates != memory_.candidate) std::copy_n(candidates, count, static_cast<std::uint32_t*>(memory_.candidate));
  tiles_ = pack_listed(evaluator_, count, memory_);
  std::fill_n(static_cast<unsigned char*>(memory_.tile_remaining), tile_count_, static_cast<unsigned char>(tile_size));
  const std::size_t filling = lanes() - count;
  if (filling > 0) memory_.tile_remaining[tile_count_ - 1] = static_cast<unsigned char>(tile_size - filling);
}

void Screening::order_by_gain(bool find_lanes) noexcept {
  const std::size_t lanes = this->lanes();
  const float top = std::max(0.0F, kernel_.largest(memory_.growths, lanes));
  // Lanes are candidates in the order of the store; else `lane` is scratch until it is filled below.
  std::uint32_t* const order = is_store_order_ ? memory_.candidate : memory_.lane;
  const std::size_t count = order_lanes(memory_.growths, memory_.remaining, lanes, top, evaluator_.team(),
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
  is_ordered_ = true;
  for (std::size_t lane = 0; find_lanes && lane < count; ++lane) {
    memory_.lane[memory_.candidate[lane]] = static_cast<std::uint32_t>(lane);
  }
  if (volume_error_ > small_volume_error) kernel_.column_max[rows_ - 1](memory_.packed, tile_count_, column_max_);
}

void Screening::begin_round(const InformationFactor& factor) noexcept {
  ++now_;
  is_trial_ = false;
  listed_ = 0;
  best_ = -1;
  assured_ = -1;
  w_ = factor.inverse();
  const double f = factor.relative_error();
  factor_drift_ = f < hopeless_error ? 2.5 * rows_ * f : std::numeric_limits<double>::infinity();
  // Once the error is small its bound may be a wide one, of an earlier round.
  const bool is_small = !with_care_ && volume_error_ <= small_volume_error && factor_drift_ < 1e-3;
  const bool may_last = rows_ < 3 && now_ > period && is_small;
  is_bounded_anew_ = !(may_last && is_lasting_) || now_ % period == 0;
  if (!is_bounded_anew_) return;
  is_lasting_ = may_last;
  bound_errors();
}

void Screening::bound_errors() noexcept {
  constexpr int n = InformationFactor::n;
  double squares = 0;  // of | |W| |h| | for the row h whose entries are the largest of their columns
  double frobenius = 0;
  for (int c = 0; c < n; ++c) {
    const double* const w = w_ + static_cast<std::size_t>(simd::padded_dimension * c);
    double sums[2] = {0, 0};
    for (int d = 0; d <= c; ++d) {
      constexpr double floor = simd::smallest_entry;
      sums[d % 2] += std::max(std::abs(w[d]), floor) * column_max_[d];
      frobenius += (w[d] * w[d] + floor * floor) * (column_max_[d] * column_max_[d]);
    }
    squares += (sums[0] + sums[1]) * (sums[0] + sums[1]);
  }
  // Six times |W D|^2, D the column maxima, is above that, and can only fall from here on.
  if (is_lasting_) squares = n * frobenius;
  const double norm = std::sqrt(squares);
  shrink_ = std::min(1.0, norm);
  const double delta = whitening_errors * unit_roundoff * norm;
  const double length = std::sqrt(1 + squares) + delta;
  volume_error_ = rows_ * delta;
  for (int row = 1; row < rows_; ++row) volume_error_ *= length;

  double growth = 0;  // (1 + squares)^rows - 1, without cancellation
  for (int row = 0; row < rows_; ++row) growth += squares + growth * squares;
  minors_error_ = minors_errors[rows_ - 1] * unit_roundoff * growth + 1e-36;

  const bool overflows = !(norm < largest_norm) || !(norm > smallest_norm);
  // Three long rows are hardly ever far from parallel.
  const bool is_hopeless = rows_ == 3 && volume_error_ > 1;
  with_care_ = overflows || is_hopeless || (with_care_ && volume_error_ > small_volume_error);
}

// |growth - exact| <= minors error + 2 sqrt(1 + growth) error + error^2, by a tangent of the square root: tight near
// this growth, true for all.
void Screening::bound_errors_near(double growth) noexcept {
  if (with_care_) {  // growths are bounds themselves
    slope_ = 1;
    offset_ = 0;
    return;
  }
  tangent_ = growth;
  const double root = std::sqrt(1 + growth);
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
}

// Of the tiles listed, the largest growth, or with care the largest lower bound of one.
float Screening::evaluate(const std::uint32_t* list, std::size_t count) noexcept {
  const auto screen = with_care_ ? kernel_.screen_with_care[rows_ - 1] : kernel_.screen[rows_ - 1];
  return screen(tiles_, w_, list, count, memory_.growths, memory_.highest);
}

// What `best`, found by evaluate, tells about all candidates.
void Screening::learn_from(float best) noexcept {
  best_ = std::max(best_, best);
  if (with_care_) assured_ = std::max(assured_, static_cast<double>(best));
  if (with_care_ || best_ < 0) return;
  const auto growth = static_cast<double>(best_);
  const double ratio = (1 + growth) / (1 + tangent_);
  if (!(ratio > 0.25 && ratio < 4)) bound_errors_near(growth);
  assured_ = std::max(assured_, growth - ((slope_ - 1) * growth + offset_));
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
  if (is_bounded_anew_) bound_errors_near(0);
  evaluate_listed();
  all_slope_ = slope_;
  all_offset_ = offset_;
  evaluations_ += remaining_;
}

// The tiles listed.
void Screening::evaluate_listed() noexcept {
  float best[threading::Team::most_chunks];
  const std::uint32_t chunks = evaluator_.team().in_chunks(
      listed_, threading::Evaluator::least_tiles, 1, [&](std::size_t first, std::size_t count, std::uint32_t chunk) {
        best[chunk] = evaluate(memory_.list + first, count);
      });
  learn_from(*std::max_element(best, best + chunks));
}

void Screening::evaluate_trial(float least) noexcept {
  is_trial_ = true;
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
  Part parts[threading::Team::most_chunks];
  constexpr std::size_t least_tiles = 256;  // of a chunk: most are not looked at
  const std::uint32_t chunks = evaluator_.team().chunks_of(tile_count_, least_tiles);
  const std::size_t packs = (tile_count_ + tile_size - 1) / tile_size;
  const std::size_t room = chunks == 1 ? 0 : (packs / chunks + 2) * tile_size;  // in the list, for each chunk
  lists_all_ = false;
  std::uint32_t* const list = memory_.list + listed_;
  evaluator_.team().for_chunks(chunks, [&](std::uint32_t chunk) {
    std::uint32_t* const own = list + room * chunk;
    Part& part = parts[chunk];
    part.count = kernel_.list_between(memory_.bounds, tile_count_, chunk, chunks, least, most, own);
    part.best = evaluate(own, part.count);
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

void Screening::evaluate_promising() noexcept {
  // Tiles whose bound is well above what the best is expected to reach, by how far it fell short of the highest bound
  // in earlier rounds: they are evaluated in any case. What they hold then decides about the others.
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const float highest = kernel_.largest(memory_.bounds, tile_count_);
  const bool is_known = highest < infinity;
  const double share = 0.25 + 0.75 * expected_share_;
  const float clearly = is_known ? static_cast<float>(share * static_cast<double>(highest)) : infinity;
  if (is_bounded_anew_) bound_errors_near(is_known ? std::max(0.0, static_cast<double>(highest)) : 0);
  evaluate_between(clearly, infinity);
  const float threshold = stale_threshold();
  if (threshold < clearly) evaluate_between(threshold, float_of(bits_of(clearly) - 1));
  keep_bounds();
  if (is_known && best_ > 0) {
    const double found = std::min(1.0, static_cast<double>(best_) / static_cast<double>(highest));
    expected_share_ += 0.5 * (found - expected_share_);
  }
}

std::size_t Screening::list_survivors(const float* unlike, std::uint32_t* lanes) const noexcept {
  const double least = (assured_ - offset_) * std::max(0.0, 2 - slope_);  // 1 / slope is at least that
  const float threshold = least > 0 ? rounded_down(least) : any_candidate;
  const std::uint32_t* list = memory_.list;
  std::size_t count = listed_;
  if (lists_all_) {  // a look at 16 tiles at once
    std::uint32_t* const some = memory_.list + tile_count_;
    count = kernel_.list_between(memory_.highest, tile_count_, 0, 1, threshold, std::numeric_limits<float>::infinity(),
                                 some);
    list = some;
  }
  return kernel_.list_survivors[rows_ - 1](tiles_, memory_.growths, memory_.highest, threshold, list, count, unlike,
                                           lanes);
}

// Of candidates that are the same, entry for entry, only the first can be selected: of all those that are the same as
// the first survivor, only that one is left.
std::size_t Screening::list_distinct_survivors(std::uint32_t* lanes) const noexcept {
  const std::size_t found = list_survivors(nullptr, lanes);
  if (found <= many_survivors) return found;
  std::uint32_t first = lanes[0];
  for (std::size_t j = 1; j < found; ++j) {
    if (candidate(lanes[j]) < candidate(first)) first = lanes[j];
  }
  float entries[simd::dimension * max_block_rows];
  const float* entry = tiles_.data + first / tile_size * tiles_.tile_stride + first % tile_size;
  for (int e = 0; e < simd::dimension * rows_; ++e, entry += tiles_.entry_stride) entries[e] = *entry;
  const std::size_t others = list_survivors(entries, lanes);
  lanes[others] = first;
  return others + 1;
}

std::size_t Screening::survivors(std::uint32_t* lanes) noexcept {
  const std::size_t found = list_distinct_survivors(lanes);
  if (with_care_ || found <= many_survivors) return found;
  // One bound for all candidates tells too few of them apart.
  std::size_t kept = 0;
  for (std::size_t j = 0; j < listed_; ++j) {
    const std::uint32_t tile = memory_.list[j];
    if (slope_ * static_cast<double>(memory_.highest[tile]) + offset_ >= assured_) memory_.list[kept++] = tile;
  }
  listed_ = kept;
  lists_all_ = false;
  with_care_ = true;
  bound_errors_near(0);
  evaluate_listed();
  if (!is_trial_) keep_bounds();
  return list_distinct_survivors(lanes);
}

void Screening::remove(std::size_t lane) noexcept {
  memory_.remaining[lane] = 0;
  --remaining_;
  memory_.growths[lane] = -1;
  --memory_.tile_remaining[lane / tile_size];
  // A far outlier of a frame is selected early; error bounds should not suffer from it any longer than that.
  if (!is_ordered_ || volume_error_ <= small_volume_error) return;
  float* entry = memory_.packed + lane / tile_size * tiles_.tile_stride + lane % tile_size;
  for (int e = 0; e < simd::dimension * rows_; ++e, entry += tile_size) *entry = 0;
  kernel_.column_max[rows_ - 1](memory_.packed, tile_count_, column_max_);
}

}  // namespace maxlogdet
