// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/aligned_array.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "simd/kernel.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace maxlogdet {

/// Memory of a Screening for up to `capacity` candidates; it grows no more.
struct ScreeningMemory {
  explicit ScreeningMemory(std::size_t capacity);

  // A lane is a place for a candidate; lanes come in whole tiles.
  AlignedArray<float> records;                 ///< the store by candidates
  AlignedArray<float> packed;                  ///< tiles of rearranged candidates
  AlignedArray<std::uint32_t> candidate;       ///< per lane: whose it is
  AlignedArray<float> remaining;               ///< per lane: 1 where there is a candidate that remains, else 0
  AlignedArray<float> relative_gains;          ///< per lane: when last evaluated
  AlignedArray<float> lower;                   ///< per lane: lower bounds, when last evaluated with care
  AlignedArray<float> values;                  ///< per lane: scratch
  AlignedArray<std::uint32_t> bucket;          ///< per lane: scratch
  AlignedArray<std::uint32_t> order_counts;    ///< scratch of order_lanes
  AlignedArray<float> highest;                 ///< per tile: the largest relative gain, when last evaluated
  AlignedArray<float> bounds;                  ///< per tile: no exact relative gain is above it
  AlignedArray<std::uint32_t> list;            ///< per tile: scratch
  AlignedArray<unsigned char> tile_remaining;  ///< per tile: candidates that remain
  AlignedArray<std::uint32_t> lane;            ///< per candidate: where it is; also scratch
};

inline std::size_t tiles_of(std::size_t count) noexcept { return (count + simd::tile_size - 1) / simd::tile_size; }

/// Tiles of the first `count` candidates of memory.candidate, in that order, copied together from their records; all of
/// them remain. Lanes that fill the last tile up do not.
simd::Tiles pack_listed(const threading::Evaluator& evaluator, simd::Form form, std::size_t count,
                        ScreeningMemory& memory) noexcept;

/// The float32 look at the candidates. A round evaluates tiles of 16 and keeps, by a proven bound of the rounding error
/// (docs/numerics.md), every candidate whose float64 gain could be the largest; usually that is a single one.
class Screening {
 public:
  /// Candidates in the order of the store. `column_max`: the largest |entry| of each column, of any row, as
  /// simd::ColumnMax has it for this form.
  Screening(const threading::Evaluator& evaluator, simd::Form form, const double* column_max,
            ScreeningMemory& memory) noexcept
      : evaluator_(evaluator), kernel_(evaluator.kernel()), form_(form), rows_(simd::rows_of(form)), memory_(memory) {
    std::copy_n(column_max, simd::dimension, column_max_);
  }

  /// Tiles of all `n` candidates in the order of the store, where they are; `free`: per candidate, 0 leaves it out.
  void use_store(const unsigned char* free, std::size_t n) noexcept;

  /// Prepares for use_listed.
  void make_records(std::size_t n) noexcept;

  /// The same for no more than these candidates, in ascending order, and those next to them.
  void make_records_of(const std::uint32_t* candidates, std::size_t count) noexcept;

  /// Forgets what earlier rounds have told about rounding errors, which holds only as long as candidates are taken out
  /// and information grows. `column_max`: as above. The bounds of tiles stay.
  void restart(const double* column_max) noexcept;

  /// Tiles of these candidates in this order, copied together. After make_records.
  void use_listed(const std::uint32_t* candidates, std::size_t count) noexcept;

  /// Tiles of what remains, in descending order of the gains that evaluate_all has just found, so that a tile holds
  /// like gains. `find_lanes`: lane_of will be asked.
  void order_by_gain(bool find_lanes) noexcept;

  /// Whether the tiles hold all that remains, not only what is listed.
  bool holds_all() const noexcept { return is_store_order_ || is_ordered_; }

  /// Starts a round with this information; nothing is evaluated yet.
  void begin_round(const InformationFactor& factor) noexcept;

  /// Evaluates every tile.
  void evaluate_all() noexcept;

  /// Evaluates the tiles of the highest bounds, then every other tile whose bound does not prove that the `wanted` best
  /// candidates are elsewhere. Gains only shrink, so a bound found in an earlier round still holds. Once more in the
  /// same round, after candidates were withdrawn, it evaluates what now matters besides.
  void evaluate_promising(std::size_t wanted) noexcept;

  /// The same where all is evaluated already.
  void look_again(std::size_t wanted) noexcept;

  /// Ends a round: remembers bounds of what it has evaluated.
  void end_round() noexcept;

  /// Evaluates the tiles with a bound of at least that much, and leaves bounds as they are.
  void evaluate_trial(float least) noexcept;

  /// The highest bound of a tile; below 0 if nothing remains.
  float highest_bound() const noexcept { return highest_bound_; }

  /// Lists the lanes whose float64 gain may be the largest of all: none only if no candidate remains. Returns how many.
  std::size_t survivors(std::uint32_t* lanes) noexcept;

  /// Lists those whose float64 gain may be among the `wanted` largest; all if fewer remain.
  std::size_t survivors(std::size_t wanted, std::uint32_t* lanes) noexcept;

  std::size_t lanes() const noexcept { return simd::tile_size * tile_count_; }

  std::uint32_t candidate(std::size_t lane) const noexcept {
    return is_store_order_ ? static_cast<std::uint32_t>(lane) : memory_.candidate[lane];
  }

  /// A lower bound of this round's largest exact relative gain.
  double assured() const noexcept { return assured_; }

  /// No exact relative gain in the tile of this lane is above it, when it was kept or, up to the drift of the factor,
  /// later.
  float bound(std::size_t lane) const noexcept { return memory_.bounds[lane / simd::tile_size]; }

  /// The lane of a candidate, where they hold all; lanes() if it does not remain.
  std::size_t lane_of(std::uint32_t wanted) const noexcept {
    const std::size_t lane = is_store_order_ ? wanted : memory_.lane[wanted];
    const bool is_there = lane < lanes() && candidate(lane) == wanted && memory_.remaining[lane] > 0;
    return is_there ? lane : lanes();
  }

  /// Within a round, after candidates were withdrawn: the lane of the best of what remains, if float32 can tell that no
  /// other one in what is evaluated, and nothing in what is not, gains as much. lanes() if it cannot: then the round
  /// goes on with evaluate_promising and survivors.
  std::size_t next_certain() noexcept;

  /// The entries of the candidate in a lane, float32, one every `stride` floats: of its form.
  const float* entries(std::size_t lane) const noexcept {
    return tiles_.data + lane / simd::tile_size * tiles_.tile_stride + lane % simd::tile_size;
  }
  std::size_t entry_stride() const noexcept { return tiles_.entry_stride; }

  /// There will be calls of withdraw.
  void expect_withdrawals() noexcept { are_withdrawn_ = true; }

  /// Takes a candidate that remains out, at the end of a round.
  void remove(std::size_t lane) noexcept;

  /// The same within a round, which goes on with what else it has evaluated.
  void withdraw(std::size_t lane) noexcept;

  int rows() const noexcept { return rows_; }

  /// Gains evaluated so far.
  std::size_t evaluations() const noexcept { return evaluations_; }

 private:
  float evaluate(const std::uint32_t* list, std::size_t count) noexcept;
  void evaluate_listed() noexcept;
  void learn_from(float best) noexcept;
  void evaluate_between(float least, float most) noexcept;
  void evaluate_down_to(float least) noexcept;
  bool evaluate_at_once(float clearly) noexcept;
  void keep_bounds() noexcept;
  float best_listed(std::size_t wanted) noexcept;
  float share_of_expected() const noexcept;
  float highest_unlisted() const noexcept;
  void bound_errors() noexcept;
  void bound_volumes(double squares) noexcept;
  void bound_errors_near(double relative_gain) noexcept;
  void look_with_care() noexcept;

  /// Above every exact relative gain of a tile, given its highest relative gain, -1 where nothing remains.
  struct Line {
    float slope, offset;
    float at(float highest) const noexcept { return highest < 0 ? -1.0F : slope * highest + offset; }
  };
  Line upper_line() const noexcept;

  std::size_t remaining_in(const std::uint32_t* list, std::size_t count) const noexcept;
  std::size_t list_survivors(const float* unlike, std::uint32_t* lanes) const noexcept;
  std::size_t list_distinct_survivors(std::uint32_t* lanes) const noexcept;
  std::size_t drop_copies(std::uint32_t* lanes, std::size_t count, std::uint32_t first) const noexcept;
  float stale_threshold() const noexcept;
  float survivor_threshold() const noexcept;

  const threading::Evaluator& evaluator_;
  const simd::Kernel& kernel_;
  simd::Form form_;
  int rows_;
  ScreeningMemory& memory_;
  double column_max_[simd::dimension];  // of candidates that remain, at least

  simd::Tiles tiles_{};
  std::size_t tile_count_ = 0;
  std::size_t remaining_ = 0;  // lanes with a candidate that remains
  std::size_t evaluations_ = 0;
  bool is_store_order_ = true;
  bool is_ordered_ = false;                // tiles hold all that remains, by gain
  bool are_withdrawn_ = false;             // candidates will be, within rounds
  bool lists_all_ = false;                 // the list is of all tiles, in their order
  bool are_bounds_kept_ = false;           // in this round
  bool is_bounded_anew_ = true;            // rounding errors are, in this round
  bool is_lasting_ = false;                // what bounds |Y| holds for later rounds too
  bool with_care_ = false;                 // bounds of the rounding error for each candidate, not one for all
  double expected_share_ = 0.9;            // of the highest bound that the best relative gain of a round reaches
  double all_slope_ = 1, all_offset_ = 0;  // when evaluate_all was last called

  // This round.
  const float* w_ = nullptr;         // W, in float32
  const double* w64_ = nullptr;      // W
  std::size_t listed_ = 0;           // tiles evaluated: list[0 .. listed_)
  std::size_t survivors_found_ = 0;  // where they are known already: bucket[0 .. survivors_found_)
  float lowest_listed_ = 0;          // all tiles of at least this bound are evaluated
  float best_ = -1;                  // the largest relative gain found; with care, the largest lower bound
  float highest_bound_ = std::numeric_limits<float>::infinity();  // of a tile, when the round began
  float next_highest_bound_ = -1;                                 // when it has ended
  double assured_ = -1;                                           // some exact relative gain is at least that
  double slope_ = 1, offset_ = 0;  // an exact relative gain is at most slope * relative gain + offset
  double tangent_ = 0;             // the relative gain near which that is tight
  double factor_drift_ = 0;        // relative error of det between this round and any earlier one

  // What rounding can do, in this round and perhaps in later ones.
  double whitened_squares_ = 0;  // of the rows of Y: no |y|^2 is above it
  double delta_ = 0;             // no row of Y is off by more
  double volume_error_ = 0;      // E of docs/numerics.md: of sqrt(det) of any candidate
  double shrink_ = 0;            // min(1, |y|): how much of it a relative gain can feel
  double minors_error_ = 0;      // of the relative gain of any candidate, by the arithmetic after Y
  double bounded_drift_ = 0;     // up to which these hold
  float bounded_highest_ = 0;    // highest_bound_ when they were found
};

}  // namespace maxlogdet
