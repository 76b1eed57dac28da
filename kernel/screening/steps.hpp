// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/evaluator.hpp"
#include "kernel/screening/error_bounds.hpp"
#include "kernel/screening/screening.hpp"
#include "kernel/screening/tiles.hpp"
#include "simd/round.hpp"

#include <cstddef>

namespace maxlogdet {

/// The steps of simd::prove_best where they cannot be inlined into one kernel: several threads, several candidates to
/// prove, in float64, or a round that goes on after removals.
class CalledSteps {
 public:
  /// `goes_on`: the round has evaluated tiles before.
  CalledSteps(const Evaluator& evaluator, const TileLayout& tiles, const ErrorBounds& errors, ScreeningMemory& memory,
              const InformationFactor& factor, std::size_t k, bool goes_on) noexcept
      : evaluator_(evaluator),
        tiles_(tiles),
        memory_(memory),
        errors_(errors),
        factor_(factor),
        k_(k),
        goes_on_(goes_on) {}

  /// At most the k-th largest value of the evaluated tiles: that of their maxima, where these are enough.
  float best(const simd::Round& round) const noexcept;

  float highest_left(const simd::Round& round) const noexcept {
    return evaluator_.kernel().bounds.highest_unevaluated(tiles_.tiles(), round);
  }

  float evaluate(simd::Round& round, float from) noexcept;

 private:
  std::size_t rank(const simd::Round& round, bool by_tiles) const noexcept;
  void evaluate_in_float32(simd::Round& round, float from) noexcept;
  void evaluate_in_float64(simd::Round& round, float from) noexcept;
  void note(simd::Round& round, const simd::Evaluated& found) noexcept;

  const Evaluator& evaluator_;
  const TileLayout& tiles_;
  ScreeningMemory& memory_;
  const ErrorBounds& errors_;
  const InformationFactor& factor_;
  std::size_t k_;
  bool goes_on_;
  float found_ = -1;  // the largest value of all tiles evaluated by these steps
};

}  // namespace maxlogdet
