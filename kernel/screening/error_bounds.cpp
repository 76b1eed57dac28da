// SPDX-License-Identifier: MIT
#include "kernel/screening/error_bounds.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/information/whitened_rows.hpp"
#include "simd/rounding.hpp"

#include <cmath>

namespace maxlogdet {
namespace {

using simd::float_unit_roundoff;

// Rounding errors in units of 2^-24 (docs/numerics.md): of a row of Y per form, and of the sum of minors per rows.
constexpr double whitening_errors[] = {8, 8, 8, 12};
constexpr double minors_errors[] = {8, 32, 160};
static_assert(sizeof whitening_errors / sizeof(double) == simd::forms, "one of each form");
static_assert(sizeof minors_errors / sizeof(double) == max_block_rows, "one of each number of rows");
// For |Y| between these no float32 operation of the kernels overflows, or loses more to underflow than bounds allow.
constexpr double largest_norm = 1e6;
constexpr double smallest_norm = 1e-15;
// The error of sqrt(det) below which one bound for all candidates is as good as one for each.
constexpr double small_volume_error = 1e-3;
// Bounds are recomputed when the highest stale bound has fallen below this share of the one that they were made with.
constexpr float outdated_share = 0.75F;
// The maximum drift for which bounds of |Y| are kept from round to round.
constexpr double small_drift = 1e-3;

}  // namespace

bool ErrorBounds::is_small() const noexcept { return volume_error_ <= small_volume_error; }

bool ErrorBounds::still_hold(bool may_last, float highest) const noexcept {
  const bool are_outdated = highest < outdated_share * highest_when_bounded_ || drift_ > drift_limit_;
  return may_last && is_lasting_ && !are_outdated;
}

void ErrorBounds::begin_round(const InformationFactor& factor, bool may_last, float highest, double expected,
                              simd::Round& round) noexcept {
  const double f = factor.relative_error();
  drift_ = f < hopeless_error ? drift_of_error * rows_ * f : infinity;
  round.drift = drift_;
  // Once the error is small, the wider bound of an earlier round suffices.
  may_last = may_last && !with_care_ && is_small() && drift_ < small_drift;
  if (still_hold(may_last, highest)) return;
  is_lasting_ = may_last;
  bound_rows(factor.inverse());
  tighten(highest);
  round.filter = {};
  if (with_care_) return;
  // |relative gain - exact| <= minors error + 2 sqrt(1 + relative gain) error + error^2
  round.filter.error = volume_error_ * shrink_;
  round.filter.constant = volume_error_ * volume_error_ + minors_error_;
  round.filter.take_tangent_at(std::max(0.0, expected));
}

void ErrorBounds::take_care(simd::Round& round) noexcept {
  with_care_ = true;
  round.filter = {};
}

void ErrorBounds::bound_rows(const double* w) noexcept {
  const WhitenedRowBounds bounds = bound_whitened_rows(w, column_max_);
  row_squares_ = is_lasting_ ? simd::dimension * bounds.frobenius : bounds.squares;
  const double norm = std::sqrt(row_squares_);
  delta_ = whitening_errors[form_] * float_unit_roundoff * norm;
  bound_volumes(row_squares_);

  const bool overflows = !(norm < largest_norm) || !(norm > smallest_norm);
  // Three long rows are nearly always almost parallel.
  const bool is_hopeless = rows_ == 3 && volume_error_ > 1;
  with_care_ = overflows || is_hopeless || (with_care_ && !is_small());
}

// `squares`: an upper bound of |y|^2 for every row y of Y.
void ErrorBounds::bound_volumes(double squares) noexcept {
  const double length = std::sqrt(1 + squares) + delta_;
  shrink_ = std::min(1.0, std::sqrt(squares));
  volume_error_ = rows_ * delta_;
  double relative_gain = squares;  // (1 + squares)^rows - 1, without cancellation
  for (int row = 1; row < rows_; ++row) {
    volume_error_ *= length;
    relative_gain += squares + relative_gain * squares;
  }
  minors_error_ = minors_errors[rows_ - 1] * float_unit_roundoff * relative_gain + 1e-36;
}

// det(I + Y Y^T) - 1 >= |y|^2 for each row y of Y: no row is longer than the root of the highest relative gain.
void ErrorBounds::tighten(float highest) noexcept {
  drift_limit_ = 2 * drift_;
  highest_when_bounded_ = highest;
  if (with_care_ || !(highest < float_infinity)) return;
  const double bound = highest;
  const double squares = bound + (1 + bound) * drift_limit_;
  bound_volumes(std::min(row_squares_, 1.1 * std::max(0.0, squares) + 12 * delta_ * delta_));
}

}  // namespace maxlogdet
