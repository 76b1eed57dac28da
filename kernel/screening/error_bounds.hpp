// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"
#include "simd/kernel.hpp"
#include "simd/upper_line.hpp"

#include <algorithm>

namespace maxlogdet {

/// Bounds of the error of float32 relative gains, for any candidate (docs/numerics.md proves them).
/// line() is above exact relative gains: a tangent that is tight near one value.
///
/// One bound serves all candidates as long as it separates them. Where it does not, screening is done *with care*: each
/// candidate has an upper and a lower bound of its own, and line() is the identity.
class ErrorBounds {
 public:
  /// `column_max`: the maximum |entry| of each column over all rows, as simd::ColumnMax for this form.
  ErrorBounds(simd::Form form, const double* column_max) noexcept : form_(form), rows_(simd::rows_of(form)) {
    std::copy_n(column_max, simd::dimension, column_max_);
  }

  /// Discards bounds of earlier rounds, which hold only while candidates are removed and information increases.
  void restart(const double* column_max) noexcept;

  /// The same maxima, to be lowered after large candidates were removed.
  double* column_max() noexcept { return column_max_; }

  /// Starts a round with this information. `may_last`: from here on candidates are only removed, so that bounds may
  /// serve later rounds; `highest_bound`: an upper bound of every exact relative gain, +infinity if none is known.
  void begin_round(const InformationFactor& factor, bool may_last, float highest_bound) noexcept;

  /// Whether this round needs tighten() or keep_wide() before its first evaluation.
  bool is_new() const noexcept { return is_new_; }

  /// Tightens the bounds by `highest_bound`: no row of Y is longer than its root.
  void tighten(double highest_bound) noexcept;
  /// Keeps them as they are, for a `highest_bound` that proves nothing.
  void keep_wide(double highest_bound) noexcept {
    drift_limit_ = 2 * drift_;
    highest_when_bounded_ = static_cast<float>(highest_bound);
  }

  /// Makes the tangent tight near this relative gain.
  void set_tangent(double relative_gain) noexcept;
  /// Whether the tangent is tight at this relative gain.
  bool is_tight_at(double relative_gain) const noexcept {
    return relative_gain > tight_above() && relative_gain < tight_below();
  }
  double tight_above() const noexcept { return (1 + tangent_) / far_from_tangent - 1; }
  double tight_below() const noexcept { return (1 + tangent_) * far_from_tangent - 1; }

  const simd::UpperLine& line() const noexcept { return line_; }
  /// Restores a line() of before.
  void restore(const simd::UpperLine& line) noexcept { line_ = line; }

  /// (1 - drift()) (1 + an exact relative gain) is at most 1 + its stale bound.
  double drift() const noexcept { return drift_; }

  bool with_care() const noexcept { return with_care_; }
  void take_care() noexcept {
    with_care_ = true;
    set_tangent(0);
  }

  /// Whether one bound for all candidates is as good as one for each.
  bool is_small() const noexcept;

 private:
  // A tangent of sqrt(1 + relative gain) counts as tight within this factor of 1 + relative gain.
  static constexpr double far_from_tangent = 4;

  void bound_rows(const double* w) noexcept;
  void bound_volumes(double squares) noexcept;

  simd::Form form_;
  int rows_;
  double column_max_[simd::dimension];  // of at least the remaining candidates

  bool is_new_ = true;
  bool is_lasting_ = false;  // the bound of |Y| also holds in later rounds
  bool with_care_ = false;
  simd::UpperLine line_;
  double tangent_ = 0;              // the relative gain near which the line is tight
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
