// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/evaluator.hpp"
#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

inline std::size_t tiles_of(std::size_t count) noexcept { return (count + simd::tile_size - 1) / simd::tile_size; }

/// Lanes to allocate for `count` candidates: whole tiles, and one more that vector stores may write to.
inline std::size_t lanes_for(std::size_t count) noexcept { return simd::tile_size * (tiles_of(count) + 1); }

/// Memory of a TileLayout for up to `capacity` candidates, allocated once.
struct TileMemory {
  explicit TileMemory(std::size_t capacity);

  AlignedArray<float> records;                 ///< the entries of each candidate together, to gather from
  AlignedArray<float> packed;                  ///< tiles of rearranged candidates
  AlignedArray<std::uint32_t> candidate;       ///< per lane: the candidate in it
  AlignedArray<float> remaining;               ///< per lane: 1 where a candidate remains, else 0
  AlignedArray<unsigned char> tile_remaining;  ///< per tile: the number of candidates that remain
  AlignedArray<std::uint32_t> lane;            ///< per candidate: its lane; before that, lanes in the new order
  AlignedArray<std::uint32_t> bucket;          ///< per lane: as order_lanes returns it
  AlignedArray<std::uint32_t> order_counts;    ///< counters of order_lanes
};

/// The arrangement of candidates in tiles: in the order of the store, as listed, or in descending order of a value.
class TileLayout {
 public:
  TileLayout(const Evaluator& evaluator, simd::Form form, TileMemory& memory) noexcept
      : evaluator_(evaluator), form_(form), memory_(memory) {}

  /// Tiles of the first n candidates in the order of the store, not copied unless factored; free[i] == 0 excludes i.
  void use_store(const unsigned char* free, std::size_t n) noexcept;

  /// Prepares use_listed() for the first `n` candidates.
  void make_records(std::size_t n) noexcept;

  /// Prepares use_listed() for these candidates alone, in ascending order.
  void make_records_of(const std::uint32_t* candidates, std::size_t count) noexcept;

  /// Copies these candidates to consecutive lanes, in this order; all of them remain.
  void use_listed(const std::uint32_t* candidates, std::size_t count) noexcept;

  /// Copies the remaining candidates to lanes in descending order of values[lane] >= 0, `top` the maximum, by the
  /// buckets of order_lanes, so that the candidates of a tile have similar values. `first_of_tile(tile, bucket)` is
  /// called for each new tile with the bucket of its first lane.
  template <class FirstOfTile>
  void order_by(const float* values, float top, const FirstOfTile& first_of_tile) noexcept {
    const std::size_t count = list_ordered(values, top);
    for (std::size_t tile = 0; tile < tiles_of(count); ++tile) {
      first_of_tile(tile, memory_.bucket[order()[tile * simd::tile_size]]);
    }
    use_ordered(count);
  }

  /// Prepares lane_of() for an ordered layout.
  void find_lanes() const noexcept;

  /// Whether the tiles hold all candidates that remain, not only listed ones.
  bool holds_all() const noexcept { return is_store_order_ || is_ordered_; }
  bool is_ordered() const noexcept { return is_ordered_; }

  const simd::Tiles& tiles() const noexcept { return tiles_; }
  simd::Form form() const noexcept { return form_; }
  std::size_t tile_count() const noexcept { return tile_count_; }
  std::size_t lanes() const noexcept { return simd::tile_size * tile_count_; }
  std::size_t remaining() const noexcept { return remaining_; }

  /// The number of candidates that remain in the listed tiles.
  std::size_t remaining_in(const std::uint32_t* list, std::size_t count) const noexcept;

  std::uint32_t candidate(std::size_t lane) const noexcept {
    return is_store_order_ ? static_cast<std::uint32_t>(lane) : memory_.candidate[lane];
  }

  bool remains(std::size_t lane) const noexcept { return memory_.remaining[lane] > 0; }

  /// The lane of a candidate, given by its place, if holds_all(); lanes() if it does not remain.
  std::size_t lane_of(std::uint32_t place) const noexcept {
    const std::size_t lane = is_store_order_ ? place : memory_.lane[place];
    const bool is_there = lane < lanes() && candidate(lane) == place && remains(lane);
    return is_there ? lane : lanes();
  }

  /// The entries, of form(), of the candidate in a lane, tiles().entry_stride floats apart.
  const float* entries(std::size_t lane) const noexcept {
    return tiles_.data + lane / simd::tile_size * tiles_.tile_stride + lane % simd::tile_size;
  }

  /// Removes a remaining candidate.
  void remove(std::size_t lane) noexcept {
    memory_.remaining[lane] = 0;
    --remaining_;
    --memory_.tile_remaining[lane / simd::tile_size];
  }

  /// Sets the entries of a removed candidate's lane to 0, for find_column_max(). The layout is ordered.
  void clear_entries(std::size_t lane) noexcept;

  /// The maximum |entry| of each column of the tiles, as simd::ColumnMax. The layout is ordered.
  void find_column_max(double* column_max) const noexcept;

 private:
  std::size_t list_ordered(const float* values, float top) noexcept;
  void use_ordered(std::size_t count) noexcept;
  // Unused memory for the new order: `candidate` in the order of the store, else `lane`, which find_lanes() fills
  // later.
  std::uint32_t* order() noexcept { return is_store_order_ ? memory_.candidate : memory_.lane; }

  const Evaluator& evaluator_;
  simd::Form form_;
  TileMemory& memory_;
  simd::Tiles tiles_{};
  std::size_t tile_count_ = 0;
  std::size_t remaining_ = 0;  // lanes with a remaining candidate
  bool is_store_order_ = true;
  bool is_ordered_ = false;
};

}  // namespace maxlogdet
