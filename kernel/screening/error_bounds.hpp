// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/factor.hpp"
#include "simd/kernel.hpp"

namespace maxlogdet {

/// What an evaluated relative gain may be off by at an information, for any candidate (docs/numerics.md proves it), as
/// the filter and the drift of a round. Rounds are evaluated in float32 as long as its error bound separates
/// candidates, else in float64.
class ErrorBounds {
 public:
  ErrorBounds() = default;
  /// `column_max`: the maximum |entry| of each column over all rows, as Candidates::largest_of_form for this form.
  ErrorBounds(simd::Form form, const double* column_max) noexcept
      : form_(form), rows_(simd::rows_of(form)), column_max_(column_max) {}

  /// Discards bounds of earlier rounds, which hold only while candidates are removed and information increases.
  void forget() noexcept { in_float64_ = is_lasting_ = false; }
  /// Sets the filter of a round with this information. `may_last`: from here on candidates are only
  /// removed, so that bounds may serve later rounds; `highest`: an upper bound of every exact relative gain, +infinity
  /// if none is known; `expected`: about the best relative gain.
  void begin_round(const InformationFactor& factor, bool may_last, float highest, double expected,
                   simd::GainFilter& filter) noexcept;

  bool in_float64() const noexcept { return in_float64_; }
  /// (1 - drift) (1 + an exact relative gain) is at most 1 + the stale bound of its tile.
  double drift() const noexcept { return drift_; }
  /// From this round on, until the error bound of float32 is small.
  void use_float64(simd::GainFilter& filter) noexcept;

 private:
  bool is_small() const noexcept;
  simd::GainFilter filter_at(double tangent) const noexcept;

  simd::Form form_ = simd::one_row;
  int rows_ = 1;
  const double* column_max_ = nullptr;

  bool is_lasting_ = false;  // the bound of |Y| also holds in later rounds
  bool in_float64_ = false;
  double drift_ = 0;                // relative error of det M between this round and any earlier one
  double row_squares_ = 0;          // upper bound of |y|^2 for every row y of Y, for its error
  double tight_squares_ = 0;        // another, for all else
  double volume_error_ = 0;         // E of docs/numerics.md in float32: error of sqrt(det) of any candidate
  double drift_limit_ = 0;          // the maximum drift for which the bounds hold
  float highest_when_bounded_ = 0;  // the highest stale bound when they were computed
};

}  // namespace maxlogdet
