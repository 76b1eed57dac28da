// SPDX-License-Identifier: MIT
#include "kernel/target.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet {
namespace {

constexpr int n = state_dimension;
constexpr int first_of_translation = 0;
constexpr int first_of_rotation = 3;

// The trace of the 3 x 3 block of M^-1 = W^T W that begins there, in units of unit^2: each entry is divided before it
// is squared, so that no square leaves the range of float64 where the answer depends on it.
double scaled_trace(const InformationFactor& factor, int first, double per_unit) noexcept {
  const double* const w = factor.inverse();
  double sums[3] = {};
  for (int row = 0; row < n; ++row) {
    for (int d = 0; d < 3; ++d) {
      const double entry = w[simd::padded_dimension * row + first + d] * per_unit;
      sums[d] += entry * entry;
    }
  }
  return sums[0] + sums[1] + sums[2];
}

bool is_within(const InformationFactor& factor, int first, double sigma) noexcept {
  return !(sigma > 0) || scaled_trace(factor, first, 1 / sigma) <= 1;
}

double deviation(const InformationFactor& factor, int first, double asked) noexcept {
  return asked > 0 ? std::sqrt(scaled_trace(factor, first, 1)) : std::numeric_limits<double>::quiet_NaN();
}

bool is_deviation(double sigma) noexcept { return sigma >= 0 && sigma < std::numeric_limits<double>::infinity(); }

}  // namespace

Target::Target(const Options& options) noexcept
    : is_asked_(is_asked(options)),
      share_(options.target_efficiency),
      translation_sigma_(options.target_translation_sigma),
      rotation_sigma_(options.target_rotation_sigma) {}

Status Target::check(const Options& options) noexcept {
  if (!is_asked(options)) return Status::ok;
  const bool is_share = options.target_efficiency >= 0 && options.target_efficiency <= 1;
  if (!is_share || !is_deviation(options.target_translation_sigma) || !is_deviation(options.target_rotation_sigma))
    return Status::invalid_target;
  return options.exchange_sweeps > 0 ? Status::unsupported_target : Status::ok;
}

void Target::compare_with(const InformationFactor& all) noexcept {
  for (int c = 0; c < n; ++c) diagonal_of_all_[c] = 1 / all.inverse()[simd::padded_dimension * c + c];
}

// det M / det M_all is the product of (1 / (W_cc L_cc))^2, L that of all, in which no factor is above 1: an entry
// L_cc^2 is what the first c directions leave of the c-th, and only grows with information. By pairs, each with its
// share, no product of them leaves the range of float64 unless the answer is clear (docs/numerics.md).
bool Target::is_met(const InformationFactor& factor) const noexcept {
  if (share_ > 0) {
    const double* const w = factor.inverse();
    double pairs[n / 2];
    for (int j = 0; j < n / 2; ++j) {
      const int c = 2 * j;
      const double first = w[simd::padded_dimension * c + c] * diagonal_of_all_[c];
      const double second = w[simd::padded_dimension * (c + 1) + c + 1] * diagonal_of_all_[c + 1];
      pairs[j] = first * second * share_;
    }
    if (!(pairs[0] * pairs[1] * pairs[2] <= 1)) return false;
  }
  return is_within(factor, first_of_translation, translation_sigma_) &&
         is_within(factor, first_of_rotation, rotation_sigma_);
}

void Target::report(const InformationFactor& factor, Selection& selection) const noexcept {
  double root = 1;
  for (int c = 0; c < n && share_ > 0; ++c) {
    root *= std::cbrt(factor.inverse()[simd::padded_dimension * c + c] * diagonal_of_all_[c]);
  }
  selection.efficiency_of_all = share_ > 0 ? 1 / root : std::numeric_limits<double>::quiet_NaN();
  selection.translation_sigma = deviation(factor, first_of_translation, translation_sigma_);
  selection.rotation_sigma = deviation(factor, first_of_rotation, rotation_sigma_);
}

}  // namespace maxlogdet
