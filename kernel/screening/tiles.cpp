// SPDX-License-Identifier: MIT
#include "kernel/screening/tiles.hpp"

#include "kernel/screening/lane_order.hpp"

#include <maxlogdet/block_store.hpp>

#include <algorithm>

namespace maxlogdet {

using simd::tile_size;

TileMemory::TileMemory(std::size_t capacity)
    : records(lanes_for(capacity) * simd::record_size(simd::three_rows)),
      packed(lanes_for(capacity) * simd::dimension * max_block_rows),
      candidate(lanes_for(capacity)),
      remaining(lanes_for(capacity)),
      tile_remaining(tiles_of(capacity)),
      lane(lanes_for(capacity)),
      bucket(lanes_for(capacity)),
      order_counts(lane_order_counts) {}

void TileLayout::use_store(const unsigned char* free, std::size_t n) noexcept {
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
    unsigned count = 0;  // converted, not compared: GCC 12 on AArch64 sums comparisons of floats as -1 each
    for (std::size_t lane = 0; lane < tile_size; ++lane)
      count += static_cast<unsigned>(static_cast<int>(memory_.remaining[tile_size * tile + lane]));
    memory_.tile_remaining[tile] = static_cast<unsigned char>(count);
    remaining_ += count;
  }
}

void TileLayout::make_records(std::size_t n) noexcept { evaluator_.make_records(form_, n, memory_.records); }

void TileLayout::make_records_of(const std::uint32_t* candidates, std::size_t count) noexcept {
  std::size_t done = 0;  // candidates below this one have records
  for (std::size_t j = 0; j < count; ++j) {
    if (candidates[j] < done) continue;
    const std::size_t first = candidates[j] / tile_size * tile_size;
    const simd::Planes planes{evaluator_.planes().data + first, evaluator_.planes().stride};
    evaluator_.kernel().make_records[form_](planes, tile_size, memory_.records + first * simd::record_size(form_));
    done = first + tile_size;
  }
}

void TileLayout::use_listed(const std::uint32_t* candidates, std::size_t count) noexcept {
  remaining_ = count;
  is_store_order_ = false;
  is_ordered_ = false;
  tile_count_ = tiles_of(count);
  std::uint32_t* const candidate = memory_.candidate;
  if (candidates != candidate) std::copy_n(candidates, count, candidate);
  const std::size_t lanes = this->lanes();
  if (count < lanes) std::fill(candidate + count, candidate + lanes, candidate[count - 1]);
  std::fill_n(static_cast<float*>(memory_.remaining), count, 1.0F);
  std::fill(memory_.remaining + count, memory_.remaining + lanes, 0.0F);
  evaluator_.gather(form_, memory_.records, candidate, lanes, memory_.packed);
  tiles_ = {memory_.packed, tile_size * simd::entries_of(form_), tile_size, memory_.remaining};
  std::fill_n(static_cast<unsigned char*>(memory_.tile_remaining), tile_count_, static_cast<unsigned char>(tile_size));
  const std::size_t filling = lanes - count;
  if (filling > 0) memory_.tile_remaining[tile_count_ - 1] = static_cast<unsigned char>(tile_size - filling);
}

std::size_t TileLayout::list_ordered(const float* values, float top) noexcept {
  return order_lanes(values, memory_.remaining, lanes(), top, evaluator_.team(), memory_.order_counts, memory_.bucket,
                     order());
}

void TileLayout::use_ordered(std::size_t count) noexcept {
  std::uint32_t* const ordered = order();
  if (is_store_order_) {
    make_records(lanes());
  } else {
    for (std::size_t lane = 0; lane < count; ++lane) ordered[lane] = memory_.candidate[ordered[lane]];
  }
  use_listed(ordered, count);
  is_ordered_ = true;
}

void TileLayout::find_lanes() const noexcept {
  for (std::size_t lane = 0; lane < remaining_; ++lane) {
    memory_.lane[memory_.candidate[lane]] = static_cast<std::uint32_t>(lane);
  }
}

std::size_t TileLayout::remaining_in(const std::uint32_t* list, std::size_t count) const noexcept {
  std::size_t sum = 0;
  for (std::size_t j = 0; j < count; ++j) sum += memory_.tile_remaining[list[j]];
  return sum;
}

void TileLayout::clear_entries(std::size_t lane) noexcept {
  float* entry = memory_.packed + lane / tile_size * tiles_.tile_stride + lane % tile_size;
  for (std::size_t e = 0; e < simd::entries_of(form_); ++e, entry += tile_size) *entry = 0;
}

void TileLayout::find_column_max(double* column_max) const noexcept {
  evaluator_.kernel().column_max[form_](memory_.packed, tile_count_, column_max);
}

}  // namespace maxlogdet
