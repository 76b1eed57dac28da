// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/memory.hpp"
#include "kernel/information/factor.hpp"
#include "kernel/screening/error_bounds.hpp"
#include "kernel/screening/tiles.hpp"
#include "simd/kernel.hpp"
#include "threading/team.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Finds the candidates whose float64 gain may be the maximum, usually a single one. Three parts do it: a
/// TileLayout knows where each candidate is, stale bounds tell which tiles need not be evaluated, ErrorBounds what
/// float32 proves. A simd::Round is made of them (docs/architecture.md).
///
/// Without order_by_gain() every round evaluates all; from then on bounds are kept from round to round, which is right
/// because the information of the rounds only increases.
class Screening {
 public:
  /// Allocates memory for up to `capacity` candidates, once. The team lives as long as this.
  Screening(std::size_t capacity, threading::Team& team);

  /// Begins a selection among these candidates, which live until its end.
  void start(const Candidates& candidates) noexcept;
  /// Starts with other ones of them, as TileLayout::use_store and use_listed. All that is known is forgotten.
  void use_store(const unsigned char* free) noexcept;
  void use_listed(const Index* listed, std::size_t count) noexcept;

  /// Where the candidates are.
  TileLayout& layout() noexcept { return tiles_; }
  const TileLayout& layout() const noexcept { return tiles_; }

  /// Orders the remaining candidates by descending relative gain, as the last round has found them, so that a tile
  /// holds similar ones, and keeps a stale bound of each tile.
  void order_by_gain() noexcept;

  /// A round with this information: lists the lanes whose float64 gain may be the largest, and returns how many.
  std::size_t survivors(const InformationFactor& factor, Lane* lanes) noexcept;

  /// A lower bound of the last round's maximum exact relative gain.
  double assured() const noexcept { return round_.assured; }

  /// Removes a remaining candidate, between rounds.
  void remove(Lane lane) noexcept {
    tiles_.remove(lane);
    gains_[lane] = -1;
  }

  /// The stale bound of a tile: no exact relative gain in it exceeds this, but for the drift.
  float bound(Tile tile) const noexcept { return bounds_[tile]; }

  /// Gains evaluated so far.
  std::size_t evaluations() const noexcept { return evaluations_; }

 private:
  void forget() noexcept;
  void keep_bounds() noexcept;
  void begin_round() noexcept;
  void reset_round() noexcept;
  std::size_t find_survivors(Lane* lanes) noexcept;
  void prove_best() noexcept;
  simd::Evaluated evaluate(const Tile* list, std::size_t count) noexcept;
  void use_float64() noexcept;

  const Candidates* candidates_ = nullptr;
  threading::Team& team_;
  TileLayout tiles_;
  ErrorBounds errors_;
  simd::Round round_;
  ArrayOf<Tile, float> bounds_;  // as in simd::RoundArrays, this and the following
  ArrayOf<Tile, float> highest_;
  ArrayOf<Lane, float> gains_;
  AlignedArray<Tile> list_;
  const InformationFactor* factor_ = nullptr;  // of the round
  float best_ = -1;                            // the largest value evaluated in the round; below 0 if there is none
  float share_ = 1;                            // about speed alone: what share of the highest bound it may have
  float guess_ = -1;                           // the stale bound to begin at, while no best is known
  std::size_t evaluations_ = 0;
  float highest_bound_ = float_infinity;
  double expected_share_ = 0;  // predicted ratio of a round's best relative gain to its highest bound
};

}  // namespace maxlogdet
