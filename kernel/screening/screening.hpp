// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/base/limits.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/screening/error_bounds.hpp"
#include "kernel/screening/tiles.hpp"
#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Memory of a Screening for up to `capacity` candidates, allocated once.
struct ScreeningMemory {
  explicit ScreeningMemory(std::size_t capacity);

  TileMemory tiles;
  AlignedArray<float> relative_gains;     ///< per lane, when last evaluated; with care upper bounds
  AlignedArray<float> lower;              ///< per lane, when last evaluated with care: lower bounds
  AlignedArray<float> ranked;             ///< scratch: values to find the k best of
  AlignedArray<std::uint32_t> survivors;  ///< lanes listed by the kernel of a whole round
  AlignedArray<float> highest;            ///< per tile: the maximum relative gain when last evaluated
  AlignedArray<float> bounds;             ///< per tile: stale bound; no exact relative gain exceeds it
  AlignedArray<std::uint32_t> list;       ///< tiles evaluated in this round
};

/// Evaluates candidates in float32. A round evaluates tiles and keeps, by a proved bound of the rounding error
/// (docs/numerics.md), every candidate whose float64 gain may be the maximum, usually a single one.
///
/// A round is begin_round(), one or more evaluate_...(), survivors(), then end_round() if stale bounds are to be kept.
class Screening {
 public:
  /// `column_max`: the maximum |entry| of each column over all rows, as simd::ColumnMax for this form.
  Screening(const Evaluator& evaluator, simd::Form form, const double* column_max, ScreeningMemory& memory) noexcept
      : evaluator_(evaluator),
        kernel_(evaluator.kernel()),
        memory_(memory),
        tiles_(evaluator, form, memory.tiles),
        errors_(form, column_max) {}

  /// As the functions of TileLayout (after use_store, lane i is candidate i); the lists of the round before become
  /// invalid.
  void use_store(const unsigned char* free, std::size_t n) noexcept;
  void use_listed(const std::uint32_t* candidates, std::size_t count) noexcept;
  void make_records(std::size_t n) noexcept { tiles_.make_records(n); }
  void make_records_of(const std::uint32_t* candidates, std::size_t count) noexcept {
    tiles_.make_records_of(candidates, count);
  }

  /// Discards the error bounds of earlier rounds, which hold only while candidates are removed and information
  /// increases. The stale bounds of tiles stay.
  void restart(const double* column_max) noexcept { errors_.restart(column_max); }

  /// Orders the remaining candidates by descending relative gain, as evaluate_all() has just found them, so that a tile
  /// holds similar ones, and keeps a stale bound of each tile. `find_lanes`: prepares lane_of().
  void order_by_gain(bool find_lanes) noexcept;

  /// Starts a round with this information; nothing is evaluated yet.
  void begin_round(const InformationFactor& factor) noexcept;

  /// Evaluates every tile.
  void evaluate_all() noexcept;

  /// Evaluates the tiles of the highest stale bounds, then every other tile that its bound does not exclude from
  /// holding one of the k best candidates: gains only decrease as information increases. Called again in the same
  /// round, after withdrawals, it evaluates the tiles that are no longer excluded.
  void evaluate_promising(std::size_t k) noexcept;

  /// The same if all tiles are evaluated already.
  void look_again(std::size_t k) noexcept;

  /// Evaluates the tiles with a stale bound of at least `min_bound`, without updating bounds.
  void evaluate_trial(float min_bound) noexcept;

  /// Ends a round: keeps bounds of the evaluated tiles.
  void end_round() noexcept;

  /// The highest stale bound of a tile; below 0 if no candidate remains.
  float highest_bound() const noexcept { return highest_bound_; }

  /// Lists the lanes whose float64 gain may be the maximum; none only if no candidate remains. Returns how many.
  std::size_t survivors(std::uint32_t* lanes) noexcept;

  /// Lists those whose float64 gain may be among the k largest; all if fewer remain.
  std::size_t survivors(std::size_t k, std::uint32_t* lanes) noexcept;

  /// Within a round, after withdrawals: the lane of the best remaining candidate, if float32 proves that no other one,
  /// evaluated or not, gains as much; else lanes(), and the round goes on with evaluate_promising() and survivors().
  std::size_t next_certain() noexcept;

  /// A lower bound of this round's maximum exact relative gain.
  double assured() const noexcept { return assured_; }

  /// The stale bound of this lane's tile: no exact relative gain in it exceeded it when it was kept, nor, except by the
  /// drift of the factor, later.
  float bound(std::size_t lane) const noexcept { return memory_.bounds[lane / simd::tile_size]; }

  std::size_t lanes() const noexcept { return tiles_.lanes(); }
  std::uint32_t candidate(std::size_t lane) const noexcept { return tiles_.candidate(lane); }
  std::size_t lane_of(std::uint32_t candidate) const noexcept { return tiles_.lane_of(candidate); }
  bool holds_all() const noexcept { return tiles_.holds_all(); }
  int rows() const noexcept { return simd::rows_of(tiles_.form()); }

  /// Announces calls of withdraw().
  void expect_withdrawals() noexcept { are_withdrawn_ = true; }

  /// Removes a remaining candidate, between rounds.
  void remove(std::size_t lane) noexcept;

  /// The same within a round, whose other evaluations stay valid.
  void withdraw(std::size_t lane) noexcept;

  /// Gains evaluated so far.
  std::size_t evaluations() const noexcept { return evaluations_; }

 private:
  float evaluate(const std::uint32_t* list, std::size_t count) noexcept;
  void evaluate_listed() noexcept;
  simd::ScreenedTiles screen_between(float min_bound, float max_bound, std::uint32_t chunk, std::uint32_t chunks,
                                     std::uint32_t* list) noexcept;
  void evaluate_between(float min_bound, float max_bound) noexcept;
  void evaluate_down_to(float min_bound) noexcept;
  bool evaluate_at_once(float first_threshold) noexcept;
  void tighten_errors() noexcept;
  void learn_from(float best) noexcept;
  void keep_bounds() noexcept;
  float best_listed(std::size_t k) noexcept;
  float first_share() const noexcept;
  float highest_unlisted() const noexcept;
  float stale_threshold() const noexcept;

  float survivor_threshold() const noexcept;
  std::size_t list_survivors(const float* unlike, std::uint32_t* lanes) const noexcept;
  std::size_t list_distinct_survivors(std::uint32_t* lanes) const noexcept;
  std::uint32_t lane_of_first(const std::uint32_t* lanes, std::size_t count) const noexcept;
  std::size_t drop_copies(std::uint32_t* lanes, std::size_t count, std::uint32_t first) const noexcept;
  void look_with_care() noexcept;

  const Evaluator& evaluator_;
  const simd::Kernel& kernel_;
  ScreeningMemory& memory_;
  TileLayout tiles_;
  ErrorBounds errors_;

  std::size_t evaluations_ = 0;
  bool are_withdrawn_ = false;   // candidates will be withdrawn within rounds
  bool lists_all_ = false;       // the list holds all tiles, in order
  double expected_share_ = 0.9;  // predicted ratio of a round's best relative gain to its highest bound
  simd::UpperLine line_of_all_;  // of the last evaluate_all()

  // This round.
  const float* w_ = nullptr;         // W = L^-1 of the information, in float32
  std::size_t listed_ = 0;           // tiles evaluated: list[0 .. listed_)
  std::size_t survivors_found_ = 0;  // if they are known already: survivors[0 .. survivors_found_)
  bool are_bounds_kept_ = false;
  float lowest_listed_ = 0;               // all tiles of at least this bound are evaluated
  float best_ = -1;                       // the maximum relative gain found; with care, the maximum lower bound
  float highest_bound_ = float_infinity;  // of all tiles, when the round began
  float next_highest_bound_ = -1;         // the same when it ends
  double assured_ = -1;
};

}  // namespace maxlogdet
