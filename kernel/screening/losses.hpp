// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/evaluator.hpp"
#include "kernel/information/information_factor.hpp"
#include "kernel/screening/screening.hpp"
#include "kernel/screening/tiles.hpp"
#include "simd/kernel.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Memory of Losses for up to `capacity` candidates, beside that of a Screening, which it shares.
struct LossesMemory {
  explicit LossesMemory(std::size_t capacity);
  ArrayOf<Lane, double> losses;     ///< the loss when last evaluated
  ArrayOf<Tile, double> tile_loss;  ///< the minimum of its lanes
};

/// The relative loss of each candidate in the information, 1 - det(M - H^T H) / det M, in float64, by tiles.
/// Losses only increase as candidates are removed, so a tile whose minimum loss of an earlier round exceeds the minimum
/// of this one need not be evaluated again.
class Losses {
 public:
  /// `column_max`: the maximum |entry| of each column over all rows. `shared`: of a screening that is not in use.
  Losses(const Evaluator& evaluator, const double* column_max, ScreeningMemory& shared, LossesMemory& memory) noexcept;

  /// Arranges the candidates i < n of the store with is_left[i] != 0 in tiles of similar losses. `factor` is that of
  /// all of them.
  void start(const unsigned char* is_left, std::size_t n, const InformationFactor& factor) noexcept;

  /// The lane of minimum loss; ties go to the highest index. At least one candidate remains. Evaluates only tiles that
  /// may hold the minimum.
  Lane find_min(const InformationFactor& factor) noexcept;

  Candidate candidate(Lane lane) const noexcept { return tiles_.candidate(lane); }

  /// Removes a candidate.
  void remove(Lane lane) noexcept;

  /// Losses evaluated so far.
  std::size_t evaluations() const noexcept { return evaluations_; }

 private:
  void evaluate(const InformationFactor& factor, std::size_t first, std::size_t last) noexcept;
  void evaluate_all(const InformationFactor& factor) noexcept;
  void evaluate_between(const InformationFactor& factor, float min_bound, float max_bound) noexcept;
  void evaluate_lazily(const InformationFactor& factor) noexcept;
  void note_errors(const InformationFactor& factor) noexcept;
  void keep_bound(Tile tile) const noexcept;
  void keep_bounds() const noexcept;
  double min_listed() const noexcept;

  const Evaluator& evaluator_;
  const simd::Kernel& kernel_;
  ScreeningMemory& shared_;
  LossesMemory& memory_;
  TileLayout tiles_;
  double row_norm_;  // upper bound of the norm of a row

  std::size_t listed_ = 0;  // tiles evaluated in this round
  std::size_t evaluations_ = 0;

  // Maxima over all rounds so far.
  double factor_error_ = 0;    // f of the factor
  double rounding_error_ = 0;  // of a loss, given the factor
};

}  // namespace maxlogdet
