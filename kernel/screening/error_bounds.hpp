// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"
#include "simd/kernel.hpp"

#include <algorithm>

namespace maxlogdet {

/// What float32 may be off by at an information, for any candidate (docs/numerics.md proves it), as the filter and the
/// drift of a round.
///
/// One bound serves all candidates as long as it separates them. Where it does not, screening is done *with care*: each
/// candidate has an upper and a lower bound of its own, and the filter excludes nothing more.
class ErrorBounds {
 public:
  /// `column_max`: the maximum |entry| of each column over all rows, as simd::LayoutFunctions::column_max for this
  /// form.
  ErrorBounds(simd::Form form, const double* column_max) noexcept : form_(form), rows_(simd::rows_of(form)) {
    set_column_max(column_max);
  }

  /// Discards bounds of earlier rounds, which hold only while candidates are removed and information increases.
  void forget() noexcept { with_care_ = is_lasting_ = false; }
  /// Other candidates.
  void set_column_max(const double* column_max) noexcept { std::copy_n(column_max, simd::dimension, column_max_); }

  /// The maxima, to be lowered after large candidates were removed.
  double* column_max() noexcept { return column_max_; }

  /// Sets the filter and the drift of a round with this information. `may_last`: from here on candidates are only
  /// removed, so that bounds may serve later rounds; `highest`: an upper bound of every exact relative gain, +infinity
  /// if none is known; `expected`: about the best relative gain.
  void begin_round(const InformationFactor& factor, bool may_last, float highest, double expected,
                   simd::Round& round) noexcept;

  bool with_care() const noexcept { return with_care_; }
  /// From here on each candidate has bounds of its own.
  void take_care(simd::Round& round) noexcept;

  /// Whether one bound for all candidates is as good as one for each.
  bool is_small() const noexcept;

 private:
  bool still_hold(bool may_last, float highest) const noexcept;
  void bound_rows(const double* w) noexcept;
  void bound_volumes(double squares) noexcept;
  void tighten(float highest) noexcept;

  simd::Form form_;
  int rows_;
  double column_max_[simd::dimension];  // of at least the remaining candidates

  bool is_lasting_ = false;  // the bound of |Y| also holds in later rounds
  bool with_care_ = false;
  double drift_ = 0;                // relative error of det M between this round and any earlier one
  double row_squares_ = 0;          // upper bound of |y|^2 for every row y of Y
  double delta_ = 0;                // upper bound of the error of every row of Y
  double volume_error_ = 0;         // E of docs/numerics.md: error of sqrt(det) of any candidate
  double shrink_ = 0;               // min(1, |y|): the share of it that affects a relative gain
  double minors_error_ = 0;         // error of any relative gain, from the arithmetic after Y
  double drift_limit_ = 0;          // the maximum drift for which the bounds hold
  float highest_when_bounded_ = 0;  // the highest stale bound when they were computed
};

}  // namespace maxlogdet
