// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/memory.hpp"
#include "kernel/blocks/candidates.hpp"
#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace maxlogdet {

/// The bits of floats >= 0 are ordered as the floats; those of negative floats are negative.
inline std::int32_t bits_of(float value) noexcept {
  std::int32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

inline float float_of(std::int32_t bits) noexcept {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// Where each candidate is: the order of evaluation, by tiles. It is that of the store, a list's, or by descending
/// value.
class TileLayout {
 public:
  /// Allocates memory for up to `capacity` candidates, once.
  explicit TileLayout(std::size_t capacity);

  /// Lays out these candidates from here on.
  void start(const Candidates& candidates) noexcept { candidates_ = &candidates; }
  /// Copies all candidates in the order of the store; free[i] == 0 excludes i.
  void use_store(const unsigned char* free) noexcept;

  /// Prepares use_listed().
  void make_records() noexcept;

  /// Copies these candidates to consecutive lanes, in this order; all of them remain.
  void use_listed(const Index* listed, std::size_t count) noexcept;

  /// Copies the remaining candidates to lanes in descending order of values[lane] >= 0, `top` the maximum: by buckets,
  /// 32 per octave, so that the candidates of a tile have similar values, and within a bucket by lane. Values more than
  /// 16 octaves below `top` share the last bucket.
  void order_by(const float* values, float top) noexcept;
  /// After order_by(): an upper bound of the values in that tile.
  float upper_end(Tile tile, float top) const noexcept {
    return float_of(bits_of(top) - static_cast<std::int32_t>(bucket_of_tile_[tile]) * (1 << bucket_shift));
  }

  /// Whether lane_of() may be asked: not of a list.
  bool has_lane_of() const noexcept { return is_store_order_ || is_ordered_; }
  bool is_ordered() const noexcept { return is_ordered_; }

  const simd::Tiles& tiles() const noexcept { return tiles_; }
  std::size_t lanes() const noexcept { return simd::tile_size * tiles_.count; }
  /// The blocks in the lanes, as they are stored.
  simd::BlocksOfLanes blocks() const noexcept {
    return {candidates_->planes, is_store_order_ ? nullptr : candidate_.data()};
  }

  Index candidate(Lane lane) const noexcept { return candidate_[lane]; }
  bool remains(Lane lane) const noexcept { return remaining_[lane] > 0; }

  /// The lane of a candidate, if has_lane_of(); no_lane if it does not remain.
  Lane lane_of(Index candidate) const noexcept;

  /// Removes a remaining candidate.
  void remove(Lane lane) noexcept {  // NOLINT(readability-make-member-function-const): changes the layout
    remaining_[lane] = 0;
    --in_each_[simd::tile_of(lane)];
  }

 private:
  static constexpr int bucket_shift = 18;  // the bits of a float that a bucket ignores

  const simd::LayoutFunctions& functions() const noexcept { return candidates_->kernel->layouts[candidates_->form]; }
  void pack() noexcept;
  void use_tiles(std::size_t count) noexcept;
  void pack_listed(std::size_t count) noexcept;

  const Candidates* candidates_ = nullptr;
  simd::Tiles tiles_{};
  bool is_store_order_ = true;
  bool is_ordered_ = false;

  AlignedArray<float> records_;                  // the entries of each candidate together, to gather from
  AlignedArray<float> packed_;                   // the tiles
  ArrayOf<Lane, Index> candidate_;               // the candidate in each lane
  ArrayOf<Lane, float> remaining_;               // 1 where a candidate remains, else 0
  ArrayOf<Tile, unsigned char> in_each_;         // the number of candidates that remain
  ArrayOf<Index, Lane> lane_;                    // where each candidate is, once ordered
  ArrayOf<Lane, std::uint32_t> bucket_;          // of order_by(): of each lane, before
  ArrayOf<Lane, Index> ordered_;                 // in the new order; those that do not remain come last
  ArrayOf<Tile, std::uint32_t> bucket_of_tile_;  // of its first lane, in the new order
  AlignedArray<std::uint32_t> first_in_bucket_;  // too much for a real-time thread's stack
};

}  // namespace maxlogdet
