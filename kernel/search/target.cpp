// SPDX-License-Identifier: MIT
#include "kernel/search/target.hpp"

#include "kernel/base/memory.hpp"

#include <cmath>

namespace maxlogdet {
namespace {

constexpr int n = state_dimension;
constexpr int first_of_rotation = 3;

// The traces of the 3 x 3 blocks of M^-1 = W^T W.
struct Variances {
  double translation, rotation;
};

// Each entry is scaled before it is squared, so that no square that the answer depends on leaves the range of float64.
Variances scaled_variances(const InformationFactor& factor, const double* scale) noexcept {
  const double* const w = factor.inverse();
  double sums[simd::padded_dimension] = {};  // by columns: independent sums
  for (int row = 0; row < n; ++row) {
    for (int d = 0; d < simd::padded_dimension; ++d) {
      const double entry = w[simd::padded_dimension * row + d] * scale[d];
      sums[d] += entry * entry;
    }
  }
  return {sums[0] + sums[1] + sums[2], sums[3] + sums[4] + sums[5]};
}

bool is_deviation(double sigma) noexcept { return sigma >= 0 && sigma < infinity; }

}  // namespace

Target::Target(const Options& options) noexcept
    : is_asked_(is_asked(options)),
      share_(options.target.efficiency),
      has_translation_(options.target.translation_sigma > 0),
      has_rotation_(options.target.rotation_sigma > 0) {
  for (int d = 0; d < n; ++d) {
    const double sigma = d < first_of_rotation ? options.target.translation_sigma : options.target.rotation_sigma;
    per_sigma_[d] = sigma > 0 ? 1 / sigma : 0;
  }
}

Error Target::check(const Options& options) noexcept {
  if (!is_asked(options)) return Error::none;
  const bool is_share = options.target.efficiency >= 0 && options.target.efficiency <= 1;
  const bool are_deviations =
      is_deviation(options.target.translation_sigma) && is_deviation(options.target.rotation_sigma);
  return is_share && are_deviations ? Error::none : Error::invalid_target;
}

void Target::compare_with(const InformationFactor& all) noexcept {
  for (int c = 0; c < n; ++c) diagonal_of_all_[c] = 1 / all.inverse()[simd::padded_dimension * c + c];
}

// det M / det M_all is the product of (1 / (W_cc L_cc))^2, L the Cholesky factor of M_all. No factor is above 1:
// L_cc^2, a Schur complement, only increases with information. In pairs, each scaled by the share, the products leave
// the range of float64 only where the answer is clear (docs/numerics.md).
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
  if (!has_translation_ && !has_rotation_) return true;
  const Variances variances = scaled_variances(factor, per_sigma_);
  return variances.translation <= 1 && variances.rotation <= 1;
}

void Target::report(const InformationFactor& factor, Selection& selection) const noexcept {
  if (!is_asked_) return;
  double root = 1;
  for (int c = 0; c < n; ++c) {
    root *= std::cbrt(factor.inverse()[simd::padded_dimension * c + c] * diagonal_of_all_[c]);
  }
  constexpr double unscaled[simd::padded_dimension] = {1, 1, 1, 1, 1, 1, 1, 1};
  const Variances variances = scaled_variances(factor, unscaled);
  if (share_ > 0) selection.efficiency = 1 / root;
  if (has_translation_) selection.translation_sigma = std::sqrt(variances.translation);
  if (has_rotation_) selection.rotation_sigma = std::sqrt(variances.rotation);
}

}  // namespace maxlogdet
