// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/screening/error_bounds.hpp"
#include "kernel/screening/tiles.hpp"
#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>

namespace maxlogdet {

/// Memory of a Screening for up to `capacity` candidates; it never grows.
struct ScreeningMemory {
  explicit ScreeningMemory(std::size_t capacity);

  TileMemory tiles;
  AlignedArray<float> relative_gains;     ///< per lane: when last evaluated; with care upper bounds
  AlignedArray<float> lower;              ///< per lane: lower bounds, when last evaluated with care
  AlignedArray<float> ranked;             ///< values among which the best are searched for
  AlignedArray<std::uint32_t> survivors;  ///< lanes, as the kernel of a whole round lists them
  AlignedArray<float> highest;            ///< per tile: the largest relative gain, when last evaluated
  AlignedArray<float> bounds;             ///< per tile: stale bound; no exact relative gain exceeds it
  AlignedArray<std::uint32_t> list;       ///< tiles that were evaluated in this round
};

/// The float32 look at the candidates. A round evaluates tiles of 16 and keeps, by a proven bound of the rounding error
/// (docs/numerics.md), every candidate whose float64 gain could be the largest; usually that is a single one.
///
/// A round is begin_round(), one or more evaluate_...(), survivors(), then end_round() if stale bounds are to be kept.
class Screening {
 public:
  /// `column_max`: the largest |entry| of each column, of any row, as simd::ColumnMax has it for this form.
  Screening(const Evaluator& evaluator, simd::Form form, const double* column_max, ScreeningMemory& memory) noexcept
      : evaluator_(evaluator),
        kernel_(evaluator.kernel()),
        memory_(memory),
        tiles_(evaluator, form, memory.tiles),
        errors_(form, column_max) {}

  /// As the functions of TileLayout; each ends the lists of the round before.
  void use_store(const unsigned char* free, std::size_t n) noexcept;
  void use_listed(const std::uint32_t* candidates, std::size_t count) noexcept;
  void make_records(std::size_t n) noexcept { tiles_.make_records(n); }
  void make_records_of(const std::uint32_t* candidates, std::size_t count) noexcept {
    tiles_.make_records_of(candidates, count);
  }

  /// Forgets what earlier rounds have told about rounding errors, which holds only as long as candidates are taken out
  /// and information grows. The stale bounds of tiles stay.
  void restart(const double* column_max) noexcept { errors_.restart(column_max); }

  /// Orders what remains by the relative gains that evaluate_all() has just found, in descending order, so that a tile
  /// holds similar ones, and keeps a stale bound of each tile. `find_lanes`: lane_of() will be asked.
  void order_by_gain(bool find_lanes) noexcept;

  /// Starts a round with this information; nothing is evaluated yet.
  void begin_round(const InformationFactor& factor) noexcept;

  /// Evaluates every tile.
  void evaluate_all() noexcept;

  /// Evaluates the tiles of the highest stale bounds, then every other tile whose bound does not prove that the
  /// `wanted` best candidates are elsewhere: gains only decrease as information grows. Called again in the same round,
  /// after candidates were withdrawn, it evaluates what matters now besides.
  void evaluate_promising(std::size_t wanted) noexcept;

  /// The same where all tiles are evaluated already.
  void look_again(std::size_t wanted) noexcept;

  /// Evaluates the tiles with a stale bound of at least `min_bound`, and leaves bounds as they are.
  void evaluate_trial(float min_bound) noexcept;

  /// Ends a round: keeps bounds of what it has evaluated.
  void end_round() noexcept;

  /// The highest stale bound of a tile; below 0 if nothing remains.
  float highest_bound() const noexcept { return highest_bound_; }

  /// Lists the lanes whose float64 gain may be the largest of all: none only if no candidate remains. Returns how many.
  std::size_t survivors(std::uint32_t* lanes) noexcept;

  /// Lists those whose float64 gain may be among the `wanted` largest; all if fewer remain.
  std::size_t survivors(std::size_t wanted, std::uint32_t* lanes) noexcept;

  /// Within a round, after candidates were withdrawn: the lane of the best of what remains, if float32 can tell that no
  /// other one in what is evaluated, and nothing in what is not, gains as much. lanes() if it cannot: then the round
  /// goes on with evaluate_promising() and survivors().
  std::size_t next_certain() noexcept;

  /// A lower bound of this round's largest exact relative gain.
  double assured() const noexcept { return assured_; }

  /// No exact relative gain in the tile of this lane exceeded it when it was kept, nor, but for the drift of the
  /// factor, later.
  float bound(std::size_t lane) const noexcept { return memory_.bounds[lane / simd::tile_size]; }

  std::size_t lanes() const noexcept { return tiles_.lanes(); }
  std::uint32_t candidate(std::size_t lane) const noexcept { return tiles_.candidate(lane); }
  std::size_t lane_of(std::uint32_t candidate) const noexcept { return tiles_.lane_of(candidate); }
  bool holds_all() const noexcept { return tiles_.holds_all(); }
  int rows() const noexcept { return simd::rows_of(tiles_.form()); }

  /// Announces calls of withdraw().
  void expect_withdrawals() noexcept { are_withdrawn_ = true; }

  /// Takes a candidate that remains out, between rounds.
  void remove(std::size_t lane) noexcept;

  /// The same within a round, which goes on with what else it has evaluated.
  void withdraw(std::size_t lane) noexcept;

  /// Gains evaluated so far.
  std::size_t evaluations() const noexcept { return evaluations_; }

 private:
  float evaluate(const std::uint32_t* list, std::size_t count) noexcept;
  void evaluate_listed() noexcept;
  void evaluate_between(float min_bound, float max_bound) noexcept;
  void evaluate_down_to(float min_bound) noexcept;
  bool evaluate_at_once(float clearly) noexcept;
  void tighten_errors() noexcept;
  void learn_from(float best) noexcept;
  void keep_bounds() noexcept;
  float best_listed(std::size_t wanted) noexcept;
  float share_of_expected() const noexcept;
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
  bool are_withdrawn_ = false;         // candidates will be, within rounds
  bool lists_all_ = false;             // the list is of all tiles, in their order
  double expected_share_ = 0.9;        // of the highest bound that the best relative gain of a round reaches
  ErrorBounds::Tangent of_all_{1, 0};  // when evaluate_all() was last called

  // This round.
  const float* w_ = nullptr;         // W = L^-1 of the information, in float32
  std::size_t listed_ = 0;           // tiles evaluated: list[0 .. listed_)
  std::size_t survivors_found_ = 0;  // where they are known already: survivors[0 .. survivors_found_)
  bool are_bounds_kept_ = false;
  float lowest_listed_ = 0;  // all tiles of at least this bound are evaluated
  float best_ = -1;          // the largest relative gain found; with care, the largest lower bound
  float highest_bound_ = std::numeric_limits<float>::infinity();  // of a tile, when the round began
  float next_highest_bound_ = -1;                                 // when it has ended
  double assured_ = -1;
};

}  // namespace maxlogdet
