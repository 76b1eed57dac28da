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
  ArrayOf<Tile, float> bounds;  ///< as in simd::RoundArrays, this and the following
  ArrayOf<Tile, float> highest;
  ArrayOf<Lane, float> gains;
  AlignedArray<Tile> list;
  AlignedArray<float> ranked;  ///< scratch: values to find the k-th largest of
};

/// Finds the candidates whose float64 gain may be the maximum, usually a single one. Three parts do it: a
/// TileLayout knows where each candidate is, stale bounds tell which tiles need not be evaluated, ErrorBounds what
/// float32 proves. A simd::Round is made of them (docs/architecture.md).
///
/// A round is begin_round(), survivors(), any number of remove() and survivors() again, and end_round(). Without
/// order_by_gain() every round evaluates all; from then on bounds are kept from round to round, which is right only
/// while the information of the rounds increases, or until forget().
class Screening {
 public:
  /// `column_max`: the maximum |entry| of each column over all rows, as simd::LayoutFunctions::column_max for this
  /// form.
  Screening(const Evaluator& evaluator, simd::Form form, const double* column_max, ScreeningMemory& memory) noexcept;

  /// Starts with other candidates, as TileLayout::use_store and use_listed. All that is known is forgotten.
  void use_store(const unsigned char* free, std::size_t n) noexcept;
  void use_listed(const Candidate* candidates, std::size_t count) noexcept;

  /// Forgets all bounds. To be called when the information is replaced by less.
  void forget() noexcept;

  /// Where the candidates are.
  TileLayout& layout() noexcept { return tiles_; }
  const TileLayout& layout() const noexcept { return tiles_; }

  /// Orders the remaining candidates by descending relative gain, as the last round has found them, so that a tile
  /// holds similar ones, and keeps a stale bound of each tile.
  void order_by_gain() noexcept;

  /// Starts a round with this information; nothing is evaluated yet.
  void begin_round(const InformationFactor& factor) noexcept;

  /// Lists the lanes whose float64 gain may be among the k largest, all if fewer remain, and returns how many. For a k
  /// of 1 at most one of several identical candidates is listed.
  std::size_t survivors(std::size_t k, Lane* lanes) noexcept;

  /// Ends a round. If the candidates are ordered, the maxima of the evaluated tiles become their stale bounds.
  void end_round() noexcept;

  /// A round of its own, after use_store(): bounds of all candidates at this information. Returns the highest; below 0
  /// if there is no candidate.
  float bound_all(const InformationFactor& factor) noexcept;

  /// A round of its own: lists the survivors of the tiles whose bound is at least `min_bound`, at an information that
  /// need not be that of the other rounds. Bounds stay as they are.
  std::size_t try_at(const InformationFactor& factor, float min_bound, Lane* lanes) noexcept;

  /// Other candidates of the store, of which bounds are known already.
  void restrict_to(const unsigned char* free) noexcept { tiles_.restrict_to(free); }

  /// A lower bound of this round's (k-th) maximum exact relative gain.
  double assured() const noexcept { return round_.assured; }

  /// Removes a remaining candidate, within a round or between rounds.
  void remove(Lane lane) noexcept;

  /// Between rounds, for Losses, which forgets what is known.
  ScreeningMemory& memory() noexcept { return memory_; }

  /// Gains evaluated so far.
  std::size_t evaluations() const noexcept { return round_.evaluations; }

 private:
  void begin(const InformationFactor& factor, float highest, float guess) noexcept;
  void keep_bounds() noexcept;
  void reset_round() noexcept;
  std::size_t find(std::size_t k, Lane* lanes) noexcept;
  bool is_inlined(std::size_t k) const noexcept;
  float first_guess() const noexcept;
  std::size_t try_guess(Lane* lanes) noexcept;
  std::size_t drop_copies(Lane* lanes, std::size_t count) const noexcept;
  void use_float64() noexcept;

  const Evaluator& evaluator_;
  const simd::Kernel& kernel_;
  const double* column_max_;
  ScreeningMemory& memory_;
  TileLayout tiles_;
  ErrorBounds errors_;
  simd::Round round_;
  const InformationFactor* factor_ = nullptr;  // of the round
  bool is_open_ = false;                       // within a round
  double last_norm_ = infinity;                // of W in the round before, to be asserted
  float highest_bound_ = float_infinity;
  double expected_share_ = 0.9;  // predicted ratio of a round's best relative gain to its highest bound
};

}  // namespace maxlogdet
