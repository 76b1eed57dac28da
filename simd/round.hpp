// SPDX-License-Identifier: MIT
#pragma once

#include "simd/gain_filter.hpp"
#include "simd/layouts.hpp"

#include <cstddef>
#include <limits>

// The round of every strategy (docs/architecture.md): evaluate the tiles that may hold the best, and no
// others.

namespace maxlogdet::simd {

/// The arrays that a round reads and writes. All hold whole registers.
struct RoundArrays {
  float* bounds;   ///< per tile: its stale bound; no exact relative gain in it exceeds this (but for the drift)
  float* highest;  ///< per tile: the maximum of `gains` when last evaluated
  float* gains;    ///< per lane: the relative gain when last evaluated, in float32 or rounded to it; -1: none there
  Tile* list;      ///< scratch: tiles to evaluate
};

/// Nothing is evaluated: NaN, which no bound reaches.
constexpr float nothing_evaluated = std::numeric_limits<float>::quiet_NaN();

/// What a round knows.
struct Round {
  RoundArrays arrays;
  GainFilter filter;
  double drift = 0;  ///< (1 - drift) (1 + an exact relative gain) is at most 1 + the stale bound of its tile

  float evaluated_from = nothing_evaluated;  ///< just the tiles of at least this stale bound are evaluated
  float best = -1;                           ///< the largest value found; below 0 if there is none
  double assured = -1;                       ///< a lower bound of the largest exact relative gain
  float share = 1;   ///< about speed alone: what share of the highest bound the best is expected to have
  float guess = -1;  ///< the stale bound to begin at, while no best is known
  std::size_t evaluations = 0;

  [[gnu::always_inline]] bool has_evaluated() const noexcept { return evaluated_from == evaluated_from; }

  /// The best found is `value`.
  [[gnu::always_inline]] void learn(float value) noexcept {
    constexpr float largest = std::numeric_limits<float>::max();
    best = value < largest ? value : largest;
    assured = -1;
    if (best < 0) return;
    filter.follow(static_cast<double>(best));
    assured = filter.at_least(static_cast<double>(best));
  }

  /// The stale bound down to which the best may be hidden, as far as is known.
  [[gnu::always_inline]] float needed() const noexcept { return best < 0 ? guess : stale_threshold(assured, drift); }
};

/// Evaluates until no tile that is left out may hold the best. `steps.best()` is the largest value so far, below 0 if
/// there is none. `steps.evaluate(round, from)` evaluates the tiles of at least this stale bound that are not evaluated
/// yet. `steps.highest_left(round)` is the highest bound of the others.
template <class Steps>
[[gnu::always_inline]] inline void prove_best(Round& round, Steps& steps) noexcept {
  for (;;) {
    round.learn(steps.best());
    if (round.best < 0 && round.has_evaluated()) round.guess = round.share * steps.highest_left(round);
    const float needed = round.needed();
    if (needed >= round.evaluated_from) return;
    steps.evaluate(round, needed);
    round.evaluated_from = needed;
  }
}

}  // namespace maxlogdet::simd
