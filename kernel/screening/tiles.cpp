// SPDX-License-Identifier: MIT
#include "kernel/screening/tiles.hpp"

#include <maxlogdet/block_store.hpp>

#include <algorithm>
#include <cassert>

namespace maxlogdet {

using simd::number;
using simd::tile_size;

namespace {

constexpr std::int32_t buckets = 512;

}  // namespace

TileLayout::TileLayout(std::size_t capacity)
    : records_(padded(capacity) * simd::record_size(simd::three_rows)),
      packed_(padded(capacity) * simd::dimension * max_block_rows),
      candidate_(padded(capacity)),
      remaining_(padded(capacity)),
      in_each_(tiles_of(capacity)),
      lane_(padded(capacity)),
      bucket_(padded(capacity)),
      ordered_(padded(capacity)),
      bucket_of_tile_(padded(capacity) / tile_size),
      first_in_bucket_(buckets + 1) {}

// Copies a plane's part in each tile; reads up to the next multiple of 16 candidates.
void TileLayout::pack() noexcept {
  const std::size_t entries = simd::entries_of(candidates_->form);
  for (std::size_t e = 0; e < entries; ++e) {
    const float* const plane =
        candidates_->planes.data + simd::plane_of(candidates_->form, e) * candidates_->planes.stride;
    for (std::size_t tile = 0; tile < tiles_.count; ++tile)
      std::copy_n(plane + tile * tile_size, tile_size, packed_ + (entries * tile + e) * tile_size);
  }
}

void TileLayout::use_tiles(std::size_t count) noexcept {
  tiles_ = {packed_, tiles_of(count), remaining_.data(), in_each_.data()};
}

void TileLayout::use_store(const unsigned char* free) noexcept {
  const std::size_t n = candidates_->count;
  is_store_order_ = true;
  is_ordered_ = false;
  use_tiles(n);
  pack();
  for (std::size_t i = 0; i < lanes(); ++i) candidate_.data()[i] = static_cast<Index>(i);
  float* const remaining = remaining_.data();
  for (std::size_t i = 0; i < n; ++i) remaining[i] = free[i] != 0 ? 1.0F : 0.0F;
  std::fill(remaining + n, remaining + lanes(), 0.0F);
  for (std::size_t tile = 0; tile < tiles_.count; ++tile) {
    unsigned count = 0;  // converted, not compared: GCC 12 on AArch64 sums comparisons of floats as -1 each
    for (std::size_t lane = 0; lane < tile_size; ++lane)
      count += static_cast<unsigned>(static_cast<int>(remaining[tile_size * tile + lane]));
    in_each_.data()[tile] = static_cast<unsigned char>(count);
  }
}

void TileLayout::make_records() noexcept {
  functions().make_records(candidates_->planes, candidates_->count, records_);
}

void TileLayout::use_listed(const Index* listed, std::size_t count) noexcept {
  std::copy_n(listed, count, candidate_.data());
  is_ordered_ = false;
  pack_listed(count);
}

// The tiles of the first `count` lanes' candidates, all of which remain; the last tile is filled with copies.
void TileLayout::pack_listed(std::size_t count) noexcept {
  is_store_order_ = false;
  use_tiles(count);
  Index* const candidate = candidate_.data();
  if (count < lanes()) std::fill(candidate + count, candidate + lanes(), candidate[count - 1]);
  functions().gather(records_, candidate, lanes(), packed_);
  float* const remaining = remaining_.data();
  std::fill_n(remaining, count, 1.0F);
  std::fill(remaining + count, remaining + lanes(), 0.0F);
  std::fill_n(in_each_.data(), tiles_.count, static_cast<unsigned char>(tile_size));
  const std::size_t filling = lanes() - count;
  if (filling > 0) in_each_.data()[tiles_.count - 1] = static_cast<unsigned char>(tile_size - filling);
}

// A counting sort.
void TileLayout::order_by(const float* values, float top) noexcept {
  std::uint32_t* const first = first_in_bucket_;
  std::uint32_t* const bucket = bucket_.data();
  std::fill_n(first, buckets + 1, 0U);  // the last bucket holds the lanes that do not remain
  for (std::size_t lane = 0; lane < lanes(); ++lane) {
    const std::int32_t below = (bits_of(top) - std::max(0, bits_of(values[lane]))) >> bucket_shift;
    const bool remains = remaining_.data()[lane] > 0;
    bucket[lane] = static_cast<std::uint32_t>(remains ? std::min(below, buckets - 1) : buckets);
  }
  for (std::size_t lane = 0; lane < lanes(); ++lane) ++first[bucket[lane]];
  std::uint32_t before = 0;
  for (std::size_t b = 0; b <= buckets; ++b) {
    const std::uint32_t in_bucket = first[b];
    first[b] = before;
    before += in_bucket;
  }
  const std::size_t count = first[buckets];
  for (std::size_t lane = 0; lane < lanes(); ++lane) {
    const std::uint32_t position = first[bucket[lane]]++;
    const Index candidate = candidate_.data()[lane];
    ordered_.data()[position] = candidate;
    if (position < count) lane_[candidate] = static_cast<Lane>(position);  // not of copies that fill a tile
    if (position % tile_size == 0) bucket_of_tile_.data()[position / tile_size] = bucket[lane];
  }
  make_records();
  candidate_.swap(ordered_);
  is_ordered_ = true;
  pack_listed(count);
}

Lane TileLayout::lane_of(Index candidate) const noexcept {
  assert(has_lane_of());
  const Lane lane = is_store_order_ ? static_cast<Lane>(candidate) : lane_[candidate];
  const bool is_there = number(lane) < lanes() && this->candidate(lane) == candidate && remains(lane);
  return is_there ? lane : no_lane;
}

}  // namespace maxlogdet
