// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information_factor.hpp"
#include "simd/kernel.hpp"

#include <algorithm>

namespace maxlogdet {

/// How far a float32 relative gain can be from the exact one, for any candidate: the proof of docs/numerics.md as code.
/// An exact relative gain is at most slope() * (its float32 value) + offset(), a tangent that is tight near one value.
///
/// One bound serves all candidates as long as it tells them apart. Where it does not, screening is done *with care*:
/// each candidate then has an upper and a lower bound of its own, and slope and offset are those of the identity.
class ErrorBounds {
 public:
  /// `column_max`: the largest |entry| of each column of any row, as simd::ColumnMax has it for this form.
  ErrorBounds(simd::Form form, const double* column_max) noexcept : form_(form), rows_(simd::rows_of(form)) {
    std::copy_n(column_max, simd::dimension, column_max_);
  }

  /// Forgets bounds of earlier rounds, which hold only while candidates are taken out and information grows.
  void restart(const double* column_max) noexcept;

  /// The same maxima, after large candidates were taken out.
  double* column_max() noexcept { return column_max_; }

  /// Starts a round with this information. `may_last`: candidates are only taken out from here on, so that bounds may
  /// serve later rounds; `highest_bound`: no exact relative gain is above it, +infinity if that is not known.
  void begin_round(const InformationFactor& factor, bool may_last, float highest_bound) noexcept;

  /// Whether this round needs tighten() before it evaluates anything.
  bool is_new() const noexcept { return is_new_; }

  /// Takes advantage of `highest_bound`: no row of Y is longer than its root.
  void tighten(double highest_bound) noexcept;
  /// The same without that knowledge.
  void keep_wide(double highest_bound) noexcept {
    drift_limit_ = 2 * drift_;
    highest_then_ = static_cast<float>(highest_bound);
  }

  /// Makes the tangent tight near this relative gain.
  void set_tangent(double relative_gain) noexcept;
  /// Whether the tangent is tight at this relative gain.
  bool is_tight_at(double relative_gain) const noexcept {
    return relative_gain > nearest() && relative_gain < farthest();
  }
  double nearest() const noexcept { return (1 + tangent_) / far_from_tangent - 1; }
  double farthest() const noexcept { return (1 + tangent_) * far_from_tangent - 1; }

  double slope() const noexcept { return slope_; }
  double offset() const noexcept { return offset_; }
  double at_most(double relative_gain) const noexcept { return slope_ * relative_gain + offset_; }
  double at_least(double relative_gain) const noexcept {
    return relative_gain - ((slope_ - 1) * relative_gain + offset_);
  }

  /// 1 + (an exact relative gain) is at most (1 + drift()) (1 + its bound of an earlier round).
  double drift() const noexcept { return drift_; }

  bool with_care() const noexcept { return with_care_; }
  void take_care() noexcept {
    with_care_ = true;
    set_tangent(0);
  }

  /// Whether one bound for all candidates is as good as one for each.
  bool is_small() const noexcept;

  /// An upper bound of every exact relative gain of a tile from the tile's highest value; -1 where nothing remains.
  struct Line {
    float slope, offset;
    float at(float highest) const noexcept { return highest < 0 ? -1.0F : slope * highest + offset; }
  };
  Line upper_line() const noexcept;

  /// The line, to be restored later.
  struct Tangent {
    double slope, offset;
  };
  Tangent tangent() const noexcept { return {slope_, offset_}; }
  void restore(const Tangent& tangent) noexcept {
    slope_ = tangent.slope;
    offset_ = tangent.offset;
  }

 private:
  // A tangent of sqrt(1 + relative gain) is tight up to that factor of 1 + relative gain.
  static constexpr double far_from_tangent = 4;

  void bound_rows(const double* w) noexcept;
  void bound_volumes(double squares) noexcept;

  simd::Form form_;
  int rows_;
  double column_max_[simd::dimension];  // of candidates that remain, at least

  bool is_new_ = true;
  bool is_lasting_ = false;  // |Y| is bounded for later rounds too
  bool with_care_ = false;
  double slope_ = 1, offset_ = 0;
  double tangent_ = 0;       // the relative gain near which the line is tight
  double drift_ = 0;         // relative error of det M between this round and any earlier one
  double row_squares_ = 0;   // no |y|^2 is above it, y a row of Y
  double delta_ = 0;         // no row of Y is off by more
  double volume_error_ = 0;  // E of docs/numerics.md: of sqrt(det) of any candidate
  double shrink_ = 0;        // min(1, |y|): the share of it that a relative gain can feel
  double minors_error_ = 0;  // of any relative gain, by the arithmetic after Y
  double drift_limit_ = 0;   // up to which these hold
  float highest_then_ = 0;   // the highest bound when they were found
};

}  // namespace maxlogdet
