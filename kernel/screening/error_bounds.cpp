// SPDX-License-Identifier: MIT
#include "kernel/screening/error_bounds.hpp"

#include "kernel/base/memory.hpp"
#include "simd/gain_filter.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

using simd::float_unit_roundoff;

// Rounding errors in units of 2^-24 (docs/numerics.md): of a row of Y per form, and of the sum of minors per rows.
constexpr double whitening_errors[] = {8, 8, 8, 12};
constexpr double minors_errors[] = {8, 32, 160};
static_assert(sizeof whitening_errors / sizeof(double) == simd::forms, "one of each form");
static_assert(sizeof minors_errors / sizeof(double) == max_block_rows, "one of each number of rows");
// Of 1 + a relative gain in float64, per form, in units of 2^-53 |y|^2; and the share of it up to which these serve.
constexpr double elimination_errors[] = {32, 128, 320, 320};
static_assert(sizeof elimination_errors / sizeof(double) == simd::forms, "one of each form");
constexpr double largest_share = 0.01;
// What a relative gain may lose that underflows in float32.
constexpr double underflow = 1e-36;
// For |Y| between these no float32 operation of the kernels overflows, or loses more to underflow than bounds allow.
constexpr double largest_norm = 1e6;
constexpr double smallest_norm = 1e-15;
// The error of sqrt(det) below which nothing is gained by lowering it.
constexpr double small_volume_error = 1e-3;
// Bounds are recomputed when the highest stale bound has fallen below this share of the one that they were made with.
constexpr float outdated_share = 0.75F;
// The maximum drift for which bounds of |Y| are kept from round to round.
constexpr double small_drift = 1e-3;

// E of docs/numerics.md: the error of sqrt(det) where every row y of Y, |y|^2 <= squares, is off by up to `delta`.
double volume_error(double squares, double delta, int rows) noexcept {
  const double length = std::sqrt(1 + squares) + delta;
  double error = rows * delta;
  for (int row = 1; row < rows; ++row) error *= length;
  return error;
}

}  // namespace

// Whether the error bound of float32 is so small that nothing is gained by lowering it.
bool ErrorBounds::is_small() const noexcept { return volume_error_ <= small_volume_error; }

void ErrorBounds::begin_round(const InformationFactor& factor, bool may_last, float highest, double expected,
                              simd::GainFilter& filter) noexcept {
  const double f = factor.relative_error();
  drift_ = f < hopeless_error ? drift_of_error * rows_ * f : infinity;
  // Once the error is small, the wider bound of an earlier round suffices.
  may_last = may_last && !in_float64_ && is_small() && drift_ < small_drift;
  const bool are_outdated = highest < outdated_share * highest_when_bounded_ || drift_ > drift_limit_;
  if (may_last && is_lasting_ && !are_outdated) return;
  is_lasting_ = may_last;
  const WhitenedRowBounds bounds = factor.bound_rows(column_max_);
  row_squares_ = tight_squares_ = is_lasting_ ? simd::dimension * bounds.frobenius : bounds.squares;
  const double norm = std::sqrt(row_squares_);
  const double delta = whitening_errors[form_] * float_unit_roundoff * norm;
  volume_error_ = volume_error(row_squares_, delta, rows_);

  const bool overflows = !(norm < largest_norm) || !(norm > smallest_norm);
  // Three long rows are nearly always almost parallel.
  const bool is_hopeless = rows_ == 3 && volume_error_ > 1;
  in_float64_ = overflows || is_hopeless || (in_float64_ && !is_small());
  drift_limit_ = 2 * drift_;
  highest_when_bounded_ = highest;
  // det(I + Y Y^T) - 1 >= |y|^2 for each row y of Y: no row is longer than the root of the highest relative gain.
  if (highest < float_infinity) {
    const double bound = highest;
    const double squares = std::max(0.0, bound + (1 + bound) * drift_limit_);
    tight_squares_ = std::min(row_squares_, 1.1 * squares + 12 * delta * delta);
    volume_error_ = volume_error(tight_squares_, delta, rows_);
  }
  filter = filter_at(std::max(0.0, expected));
}

void ErrorBounds::use_float64(simd::GainFilter& filter) noexcept {
  in_float64_ = true;
  filter = filter_at(filter.tangent);
}

simd::GainFilter ErrorBounds::filter_at(double tangent) const noexcept {
  simd::GainFilter filter;
  if (in_float64_) {
    const double share = elimination_errors[form_] * simd::double_unit_roundoff * row_squares_;
    const bool excludes = share < largest_share;
    filter.constant = excludes ? share + underflow : infinity;
    filter.relative = excludes ? share + 2 * float_unit_roundoff : 0;
  } else {
    double most = tight_squares_;  // (1 + squares)^rows - 1, without cancellation
    for (int row = 1; row < rows_; ++row) most += tight_squares_ + most * tight_squares_;
    const double minors_error = minors_errors[rows_ - 1] * float_unit_roundoff * most;
    filter.error = volume_error_ * std::min(1.0, std::sqrt(tight_squares_));
    filter.constant = volume_error_ * volume_error_ + minors_error + underflow;
  }
  filter.take_tangent_at(tangent);
  return filter;
}

}  // namespace maxlogdet
