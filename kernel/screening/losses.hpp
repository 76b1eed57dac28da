// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/aligned_array.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/screening/screening.hpp"
#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Memory of Losses for up to `capacity` candidates; of the rest it uses that of a Screening.
struct LossesMemory {
  explicit LossesMemory(std::size_t capacity);
  AlignedArray<double> losses;  ///< per lane: when last evaluated
  AlignedArray<double> least;   ///< per tile: of its lanes, when last evaluated
};

/// What each of the candidates in the information would take along: 1 - det(M - H^T H) / det M, in float64, by tiles of
/// 16. Losses only grow as candidates leave, so a tile whose least loss of an earlier round is above the least of this
/// one need not be evaluated again.
class Losses {
 public:
  Losses(const threading::Evaluator& evaluator, const double* column_max, ScreeningMemory& tiles,
         LossesMemory& memory) noexcept;

  /// The `n` candidates of the store, those with left[i] != 0, in tiles of like losses. `factor`: all of them are in.
  void start(const unsigned char* left, std::size_t n, const InformationFactor& factor) noexcept;

  /// The lane of least loss; the highest index on ties. At least one candidate remains. `lazily`: evaluates only what
  /// could be the least, with the same result.
  std::size_t least(const InformationFactor& factor, bool lazily) noexcept;

  std::uint32_t candidate(std::size_t lane) const noexcept { return tiles_memory_.candidate[lane]; }

  /// Takes a candidate out.
  void remove(std::size_t lane) noexcept;

  /// Lists all but the `kept` of largest loss, as far as losses are known; returns how many.
  std::size_t list_all_but(std::size_t kept, std::uint32_t* candidates) noexcept;

  /// Losses evaluated so far.
  std::size_t evaluations() const noexcept { return evaluations_; }

 private:
  void evaluate(const InformationFactor& factor, std::size_t first, std::size_t last) noexcept;
  void evaluate_all(const InformationFactor& factor) noexcept;
  void evaluate_between(const InformationFactor& factor, float least, float most) noexcept;
  void note_errors(const InformationFactor& factor) noexcept;
  void keep_bound(std::size_t tile) const noexcept;
  void keep_bounds() const noexcept;
  double min_listed() const noexcept;

  const threading::Evaluator& evaluator_;
  const simd::Kernel& kernel_;
  ScreeningMemory& tiles_memory_;
  LossesMemory& memory_;
  double row_norm_;  // no row is longer

  simd::Tiles tiles_{};
  std::size_t tile_count_ = 0;
  std::size_t listed_ = 0;  // tiles evaluated in this round
  std::size_t evaluations_ = 0;

  // The largest so far.
  double factor_error_ = 0;    // f of the factor
  double rounding_error_ = 0;  // of a loss, given the factor
};

}  // namespace maxlogdet
