// SPDX-License-Identifier: MIT
#include "kernel/screening.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace maxlogdet {
namespace {

using simd::tile_size;

constexpr double unit_roundoff = std::numeric_limits<float>::epsilon() / 2;
// Rounding errors of a row of Y and of a growth, in units of 2^-24 and per row of the block; generous, see
// docs/numerics.md.
constexpr double errors_per_row = 12;
// |Y| within which no float32 operation of the kernels overflows, or loses what it should not to underflow.
constexpr double largest_norm = 1e6;
constexpr double smallest_norm = 1e-15;
// An error of sqrt(det) below which one bound for all candidates is as good as one for each.
constexpr double small_volume_error = 1e-3;
// More survivors than this are looked at again with care before float64 has to decide.
constexpr std::size_t many_survivors = 24;
// Thresholds that must not let a lane through that has no candidate (growth -1).
constexpr float any_candidate = -0.5F;

// The next float32 at or beyond a bound, with room for the few roundings that lead to it.
float rounded_down(double value) noexcept { return static_cast<float>(value - std::abs(value) * 5e-7); }
float rounded_up(double value) noexcept { return static_cast<float>(value + std::abs(value) * 5e-7); }

std::size_t tiles_of(std::size_t count) noexcept { return (count + tile_size - 1) / tile_size; }

// Room for whole tiles, and for whole vectors of values per tile.
std::size_t lanes_for(std::size_t count) noexcept { return tile_size * (tiles_of(count) + 1); }

}  // namespace

ScreeningMemory::ScreeningMemory(std::size_t capacity)
    : records(lanes_for(capacity) * simd::record_size(max_block_rows)),
      packed(lanes_for(capacity) * simd::dimension * max_block_rows),
      candidate(lanes_for(capacity)),
      remaining(lanes_for(capacity)),
      growths(lanes_for(capacity)),
      sorted(lanes_for(capacity)),
      bucket(lanes_for(capacity)),
      highest(lanes_for(tiles_of(capacity))),
      bounds(lanes_for(tiles_of(capacity))),
      list(lanes_for(tiles_of(capacity))),
      tile_remaining(tiles_of(capacity)) {}

void Screening::use_store(const unsigned char* valid, std::size_t n) noexcept {
  is_store_order_ = true;
  is_ordered_ = false;
  tile_count_ = tiles_of(n);
  tiles_ = {planes_.data, tile_size, planes_.stride, memory_.remaining};
  for (std::size_t i = 0; i < n; ++i) memory_.remaining[i] = valid[i] != 0 ? 1.0F : 0.0F;
  std::fill(memory_.remaining + n, memory_.remaining + tile_size * tile_count_, 0.0F);
  count_remaining();
}

void Screening::make_records(std::size_t n) noexcept { kernel_.make_records[rows_ - 1](planes_, n, memory_.records); }

void Screening::use_listed(const std::uint32_t* candidates, std::size_t count) noexcept {
  is_store_order_ = false;
  is_ordered_ = false;
  tile_count_ = tiles_of(count);
  const std::size_t lanes = tile_size * tile_count_;
  const std::size_t tile_floats = tile_size * simd::dimension * static_cast<std::size_t>(rows_);
  tiles_ = {memory_.packed, tile_floats, tile_size, memory_.remaining};
  std::uint32_t* const candidate = memory_.candidate;
  float* const remaining = memory_.remaining;
  if (candidates != candidate) std::copy_n(candidates, count, candidate);
  if (count < lanes) std::fill(candidate + count, candidate + lanes, candidate[count - 1]);
  std::fill_n(remaining, count, 1.0F);
  std::fill(remaining + count, remaining + lanes, 0.0F);
  kernel_.gather[rows_ - 1](memory_.records, memory_.candidate, lanes, memory_.packed);
  std::fill_n(static_cast<unsigned char*>(memory_.tile_remaining), tile_count_, static_cast<unsigned char>(tile_size));
  if (count < lanes) memory_.tile_remaining[tile_count_ - 1] = static_cast<unsigned char>(tile_size - (lanes - count));
}

void Screening::count_remaining() const noexcept {
  for (std::size_t tile = 0; tile < tile_count_; ++tile) {
    float count = 0;
    for (std::size_t lane = 0; lane < tile_size; ++lane) count += memory_.remaining[tile * tile_size + lane];
    memory_.tile_remaining[tile] = static_cast<unsigned char>(count);
  }
}

void Screening::order_by_gain() noexcept {
  // A counting sort by the upper bits of the growth, which as an integer are ordered as it is: 32 steps to an octave.
  constexpr int shift = 18;
  constexpr std::size_t buckets = 1024;
  std::uint32_t first[buckets + 1] = {};
  std::uint32_t top;
  const float largest = std::max(best_, 0.0F);
  std::memcpy(&top, &largest, sizeof top);
  const std::size_t lanes = tile_size * tile_count_;
  std::uint32_t* const bucket = memory_.bucket;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    std::uint32_t bits;
    std::memcpy(&bits, memory_.growths + lane, sizeof bits);
    const std::uint32_t below = (top - std::min(bits, top)) >> shift;
    bucket[lane] = memory_.remaining[lane] > 0 ? std::min<std::uint32_t>(below, buckets - 1) : buckets;
  }
  for (std::size_t lane = 0; lane < lanes; ++lane) ++first[bucket[lane]];
  std::uint32_t count = 0;
  for (std::uint32_t& entry : first) {
    const std::uint32_t in_bucket = entry;
    entry = count;
    count += in_bucket;
  }
  count = first[buckets];  // the last bucket is of those that do not remain
  std::uint32_t* const order = memory_.candidate;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const std::uint32_t place = first[bucket[lane]]++;
    order[place] = static_cast<std::uint32_t>(lane);
    memory_.sorted[place] = memory_.growths[lane];
  }
  std::copy_n(static_cast<float*>(memory_.sorted), count, static_cast<float*>(memory_.growths));
  std::fill(memory_.growths + count, memory_.growths + tile_size * tiles_of(count), -1.0F);
  make_records(lanes);
  use_listed(order, count);
  is_ordered_ = true;
  kernel_.column_max[rows_ - 1](memory_.packed, tile_count_, column_max_);
  listed_ = tile_count_;
  for (std::size_t tile = 0; tile < tile_count_; ++tile) {
    memory_.highest[tile] = kernel_.largest(memory_.growths + tile * tile_size, tile_size);
    memory_.list[tile] = static_cast<std::uint32_t>(tile);
  }
  slope_ = all_slope_;
  offset_ = all_offset_;
  raise_bounds();
}

void Screening::begin_round(const InformationFactor& factor) noexcept {
  constexpr int n = InformationFactor::n;
  double squares = 0;  // of | |W| |h| | for the row h whose entries are the largest of their columns
  for (int c = 0; c < n; ++c) {
    const double* const w = factor.inverse() + static_cast<std::size_t>(simd::padded_dimension * c);
    double sums[2] = {0, 0};
    for (int d = 0; d < n; ++d) {  // zeros above the diagonal
      w_[n * c + d] = static_cast<float>(w[d]);
      if (d <= c) sums[d % 2] += std::max(std::abs(w[d]), simd::smallest_entry) * column_max_[d];
    }
    squares += (sums[0] + sums[1]) * (sums[0] + sums[1]);
  }
  const double norm = std::sqrt(squares);
  unit_ = errors_per_row * rows_ * unit_roundoff;
  shrink_ = std::min(1.0, norm);
  const double delta = unit_ * norm;
  const double length = std::sqrt(1 + squares) + delta;
  volume_error_ = rows_ * delta;
  for (int row = 1; row < rows_; ++row) volume_error_ *= length;

  double growth = 0;  // (1 + squares)^rows - 1, without cancellation
  for (int row = 0; row < rows_; ++row) growth += squares + growth * squares;
  constexpr double minors_errors[] = {8, 24, 102};
  minors_error_ = minors_errors[rows_ - 1] * unit_roundoff * growth + 1e-36;

  const bool overflows = !(norm < largest_norm) || !(norm > smallest_norm);
  // Three long rows are hardly ever far from parallel.
  const bool is_hopeless = rows_ == 3 && volume_error_ > 1;
  with_care_ = overflows || is_hopeless || (with_care_ && volume_error_ > small_volume_error);
  const double f = factor.relative_error();
  factor_drift_ = f < 0.125 ? 2.5 * rows_ * f : std::numeric_limits<double>::infinity();
  listed_ = 0;
  best_ = -1;
  assured_ = -1;
}

void Screening::evaluate(std::size_t first, std::size_t last) noexcept {
  if (with_care_) {
    evaluate_with_care(first, last);
    return;
  }
  const float best =
      kernel_.screen[rows_ - 1](tiles_, w_, memory_.list + first, last - first, memory_.growths, memory_.highest);
  best_ = std::max(best_, best);
  if (best_ < 0) return;
  // |growth - exact| <= unit growth + 2 volume error + error^2, for each of growths up to best_.
  const auto growth = static_cast<double>(best_);
  slope_ = 1;
  offset_ = 2 * std::sqrt(1 + growth) * volume_error_ * shrink_ + volume_error_ * volume_error_ + minors_error_;
  assured_ = growth - offset_;
}

void Screening::evaluate_with_care(std::size_t first, std::size_t last) noexcept {
  const float assured = kernel_.screen_with_care[rows_ - 1](tiles_, w_, static_cast<float>(unit_), memory_.list + first,
                                                            last - first, memory_.growths, memory_.highest);
  assured_ = std::max(assured_, static_cast<double>(assured));
  best_ = std::max(best_, assured);
  slope_ = 1;
  offset_ = 0;
}

void Screening::raise_bounds() const noexcept {
  const float slope = rounded_up(slope_ * (1 + 1e-6));  // and room for the rounding of this line and the next
  const float offset = rounded_up(offset_);
  for (std::size_t j = 0; j < listed_; ++j) {
    const std::uint32_t tile = memory_.list[j];
    const float highest = memory_.highest[tile];
    memory_.bounds[tile] = highest < 0 ? -1.0F : slope * highest + offset;
  }
}

void Screening::count_evaluations() noexcept {
  for (std::size_t j = 0; j < listed_; ++j) evaluations_ += memory_.tile_remaining[memory_.list[j]];
}

void Screening::evaluate_all() noexcept {
  for (std::size_t tile = 0; tile < tile_count_; ++tile) memory_.list[tile] = static_cast<std::uint32_t>(tile);
  evaluate(0, tile_count_);
  listed_ = tile_count_;
  count_evaluations();
  raise_bounds();
  all_slope_ = slope_;
  all_offset_ = offset_;
}

// What a bound found earlier must reach for its tile to matter.
float Screening::stale_threshold() const noexcept {
  const double threshold = assured_ - (1 + assured_) * factor_drift_;
  return threshold > 0 ? rounded_down(threshold) : any_candidate;
}

void Screening::evaluate_promising() noexcept {
  // Tiles whose bound is well above what the best is expected to reach, by how far it fell short of the highest bound
  // in earlier rounds: they are evaluated in any case. What they hold then decides about the others.
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto highest = static_cast<double>(kernel_.largest(memory_.bounds, tile_count_));
  const float clearly =
      highest < infinity ? rounded_down(highest * (0.25 + 0.75 * expected_share_)) : std::numeric_limits<float>::max();
  const std::size_t leaders = kernel_.list_at_least(memory_.bounds, tile_count_, clearly, memory_.list);
  evaluate(0, leaders);
  for (std::size_t j = 0; j < leaders; ++j) memory_.bounds[memory_.list[j]] = -1;  // not to be listed again
  const float threshold = stale_threshold();
  listed_ = leaders + kernel_.list_at_least(memory_.bounds, tile_count_, threshold, memory_.list + leaders);
  if (listed_ > leaders) evaluate(leaders, listed_);
  count_evaluations();
  raise_bounds();
  if (highest < infinity && best_ > 0) {
    const double share = std::min(1.0, static_cast<double>(best_) / highest);
    expected_share_ += 0.5 * (share - expected_share_);
  }
}

std::size_t Screening::list_survivors(const float* unlike, std::uint32_t* lanes) const noexcept {
  const double least = (assured_ - offset_) / slope_;
  const float threshold = least > 0 ? rounded_down(least) : any_candidate;
  return kernel_.list_survivors[rows_ - 1](tiles_, memory_.growths, memory_.highest, threshold, memory_.list, listed_,
                                           unlike, lanes);
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
  with_care_ = true;
  std::size_t kept = 0;
  for (std::size_t j = 0; j < listed_; ++j) {
    const std::uint32_t tile = memory_.list[j];
    if (slope_ * static_cast<double>(memory_.highest[tile]) + offset_ >= assured_) memory_.list[kept++] = tile;
  }
  listed_ = kept;
  evaluate_with_care(0, listed_);
  raise_bounds();
  return list_distinct_survivors(lanes);
}

void Screening::remove(std::size_t lane) noexcept {
  memory_.remaining[lane] = 0;
  --memory_.tile_remaining[lane / tile_size];
  // A far outlier of a frame is selected early; error bounds should not suffer from it any longer than that.
  if (!is_ordered_ || volume_error_ <= small_volume_error) return;
  float* entry = memory_.packed + lane / tile_size * tiles_.tile_stride + lane % tile_size;
  for (int e = 0; e < simd::dimension * rows_; ++e, entry += tile_size) *entry = 0;
  kernel_.column_max[rows_ - 1](memory_.packed, tile_count_, column_max_);
}

}  // namespace maxlogdet
