// SPDX-License-Identifier: MIT
#include "kernel/screening/tiles.hpp"

#include <maxlogdet/block_store.hpp>

#include <algorithm>

namespace maxlogdet {

using simd::number;
using simd::tile_size;

TileMemory::TileMemory(std::size_t capacity)
    : records(padded(capacity) * simd::record_size(simd::three_rows)),
      packed(padded(capacity) * simd::dimension * max_block_rows),
      candidate(padded(capacity)),
      remaining(padded(capacity)),
      in_each(tiles_of(capacity)),
      lane(padded(capacity)),
      order(capacity) {}

void TileLayout::use_tiles(const float* data, std::size_t tile_stride, std::size_t entry_stride,
                           std::size_t count) noexcept {
  tiles_ = {data, tile_stride, entry_stride, tiles_of(count), memory_.remaining.data(), memory_.in_each.data()};
}

void TileLayout::use_store(const unsigned char* free, std::size_t n) noexcept {
  is_store_order_ = true;
  is_ordered_ = false;
  const bool is_packed = form_ == simd::factored;
  if (is_packed) evaluator_.pack(form_, n, memory_.packed);
  is_packed ? use_tiles(memory_.packed, tile_size * simd::entries_of(form_), tile_size, n)
            : use_tiles(evaluator_.planes().data, tile_size, evaluator_.planes().stride, n);
  for (std::size_t i = 0; i < lanes(); ++i) memory_.candidate.data()[i] = static_cast<Candidate>(i);
  size_ = n;
  restrict_to(free);
}

// NOLINTNEXTLINE(readability-make-member-function-const): changes the layout
void TileLayout::restrict_to(const unsigned char* free) noexcept {
  float* const remaining = memory_.remaining.data();
  for (std::size_t i = 0; i < size_; ++i) remaining[i] = free[i] != 0 ? 1.0F : 0.0F;
  std::fill(remaining + size_, remaining + lanes(), 0.0F);
  for (std::size_t tile = 0; tile < tiles_.count; ++tile) {
    unsigned count = 0;  // converted, not compared: GCC 12 on AArch64 sums comparisons of floats as -1 each
    for (std::size_t lane = 0; lane < tile_size; ++lane)
      count += static_cast<unsigned>(static_cast<int>(remaining[tile_size * tile + lane]));
    memory_.in_each.data()[tile] = static_cast<unsigned char>(count);
  }
}

void TileLayout::make_records(std::size_t n) noexcept { evaluator_.make_records(form_, n, memory_.records); }

void TileLayout::make_records_of(const Candidate* candidates, std::size_t count) noexcept {
  std::size_t done = 0;  // candidates below this one have records
  for (std::size_t j = 0; j < count; ++j) {
    if (number(candidates[j]) < done) continue;
    const std::size_t first = number(candidates[j]) / tile_size * tile_size;
    const simd::Planes planes{evaluator_.planes().data + first, evaluator_.planes().stride};
    evaluator_.kernel().layouts[form_].make_records(planes, tile_size,
                                                    memory_.records + first * simd::record_size(form_));
    done = first + tile_size;
  }
}

void TileLayout::use_listed(const Candidate* candidates, std::size_t count) noexcept {
  std::copy_n(candidates, count, memory_.candidate.data());
  is_ordered_ = false;
  pack_listed(count);
}

// The tiles of the first `count` lanes' candidates, all of which remain; the last tile is filled with copies.
void TileLayout::pack_listed(std::size_t count) noexcept {
  is_store_order_ = false;
  use_tiles(memory_.packed, tile_size * simd::entries_of(form_), tile_size, count);
  Candidate* const candidate = memory_.candidate.data();
  if (count < lanes()) std::fill(candidate + count, candidate + lanes(), candidate[count - 1]);
  evaluator_.gather(form_, memory_.records, candidate, lanes(), memory_.packed);
  float* const remaining = memory_.remaining.data();
  std::fill_n(remaining, count, 1.0F);
  std::fill(remaining + count, remaining + lanes(), 0.0F);
  std::fill_n(memory_.in_each.data(), tiles_.count, static_cast<unsigned char>(tile_size));
  const std::size_t filling = lanes() - count;
  if (filling > 0) memory_.in_each.data()[tiles_.count - 1] = static_cast<unsigned char>(tile_size - filling);
}

void TileLayout::use_ordered(std::size_t count) noexcept {
  if (is_store_order_) make_records(lanes());
  memory_.candidate.swap(memory_.order.candidate);
  is_ordered_ = true;
  pack_listed(count);
}

void TileLayout::find_lanes() const noexcept {
  for (std::size_t i = 0; i < lanes(); ++i) {
    const auto lane = static_cast<Lane>(i);
    if (remains(lane)) memory_.lane[candidate(lane)] = lane;
  }
}

Lane TileLayout::lane_of(Candidate candidate) const noexcept {
  const Lane lane = is_store_order_ ? static_cast<Lane>(candidate) : memory_.lane[candidate];
  const bool is_there = number(lane) < lanes() && this->candidate(lane) == candidate && remains(lane);
  return is_there ? lane : no_lane;
}

void TileLayout::clear_entries(Lane lane) noexcept {
  float* entry = memory_.packed + number(lane) / tile_size * tiles_.tile_stride + number(lane) % tile_size;
  for (std::size_t e = 0; e < simd::entries_of(form_); ++e, entry += tile_size) *entry = 0;
}

void TileLayout::find_column_max(double* column_max) const noexcept {
  evaluator_.kernel().layouts[form_].column_max(memory_.packed, tiles_.count, column_max);
}

}  // namespace maxlogdet
