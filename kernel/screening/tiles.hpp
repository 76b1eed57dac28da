// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/screening/lane_order.hpp"
#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Memory of a TileLayout for up to `capacity` candidates, allocated once.
struct TileMemory {
  explicit TileMemory(std::size_t capacity);

  AlignedArray<float> records;           ///< the entries of each candidate together, to gather from
  AlignedArray<float> packed;            ///< tiles of rearranged candidates
  ArrayOf<Lane, Candidate> candidate;    ///< the candidate in each lane
  ArrayOf<Lane, float> remaining;        ///< 1 where a candidate remains, else 0
  ArrayOf<Tile, unsigned char> in_each;  ///< the number of candidates that remain
  ArrayOf<Candidate, Lane> lane;         ///< where each candidate is, if find_lanes() was called
  LaneOrderMemory order;
};

/// Where each candidate is: the order of evaluation, by tiles. It is that of the store, a list's, or by descending
/// value.
class TileLayout {
 public:
  TileLayout(const Evaluator& evaluator, simd::Form form, TileMemory& memory) noexcept
      : evaluator_(evaluator), form_(form), memory_(memory) {}

  /// The first n candidates in the order of the store, not copied unless factored; free[i] == 0 excludes i.
  void use_store(const unsigned char* free, std::size_t n) noexcept;

  /// Other candidates of the same store; the layout is that of the store.
  void restrict_to(const unsigned char* free) noexcept;

  /// Prepares use_listed() for the first `n` candidates.
  void make_records(std::size_t n) noexcept;

  /// Prepares use_listed() for these candidates alone, in ascending order.
  void make_records_of(const Candidate* candidates, std::size_t count) noexcept;

  /// Copies these candidates to consecutive lanes, in this order; all of them remain.
  void use_listed(const Candidate* candidates, std::size_t count) noexcept;

  /// Copies the remaining candidates to lanes in descending order of values[lane] >= 0, `top` the maximum, by the
  /// buckets of order_lanes, so that the candidates of a tile have similar values. `first_of_tile(tile, bucket)` is
  /// called for each new tile with the bucket of its first lane.
  template <class FirstOfTile>
  void order_by(const float* values, float top, const FirstOfTile& first_of_tile) noexcept {
    const std::size_t count = order_lanes({values, memory_.remaining.data(), memory_.candidate.data(), lanes(), top},
                                          evaluator_.team(), memory_.order);
    for (std::size_t i = 0; i < tiles_of(count); ++i) {
      const auto tile = static_cast<Tile>(i);
      first_of_tile(tile, memory_.order.bucket_of_tile[tile]);
    }
    use_ordered(count);
  }

  /// Prepares lane_of() for an ordered layout.
  void find_lanes() const noexcept;

  /// Whether lane_of() may be asked: in the order of the store, or once ordered.
  bool has_lane_of() const noexcept { return is_store_order_ || is_ordered_; }
  bool is_ordered() const noexcept { return is_ordered_; }
  bool is_store_order() const noexcept { return is_store_order_; }

  const simd::Tiles& tiles() const noexcept { return tiles_; }
  simd::Form form() const noexcept { return form_; }
  std::size_t lanes() const noexcept { return simd::tile_size * tiles_.count; }

  Candidate candidate(Lane lane) const noexcept { return memory_.candidate[lane]; }
  bool remains(Lane lane) const noexcept { return memory_.remaining[lane] > 0; }

  /// The lane of a candidate, if has_lane_of(); no_lane if it does not remain.
  Lane lane_of(Candidate candidate) const noexcept;

  /// Removes a remaining candidate.
  void remove(Lane lane) noexcept {  // NOLINT(readability-make-member-function-const): changes the layout
    memory_.remaining[lane] = 0;
    --memory_.in_each[simd::tile_of(lane)];
  }

  /// Sets the entries of a removed candidate's lane to 0, for find_column_max(). The layout is ordered.
  void clear_entries(Lane lane) noexcept;

  /// The maximum |entry| of each column of the tiles, as simd::LayoutFunctions::column_max. The layout is ordered.
  void find_column_max(double* column_max) const noexcept;

 private:
  void use_tiles(const float* data, std::size_t tile_stride, std::size_t entry_stride, std::size_t count) noexcept;
  void use_ordered(std::size_t count) noexcept;
  void pack_listed(std::size_t count) noexcept;

  const Evaluator& evaluator_;
  simd::Form form_;
  TileMemory& memory_;
  simd::Tiles tiles_{};
  std::size_t size_ = 0;  // candidates of the store
  bool is_store_order_ = true;
  bool is_ordered_ = false;
};

}  // namespace maxlogdet
