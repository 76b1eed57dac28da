// SPDX-License-Identifier: MIT
// The target in efficiency: det M / det M_all is the product of (1 / (W_cc L_cc))^2, L the Cholesky factor of M_all. No
// factor is above 1: L_cc^2, a Schur complement, only increases with information.
#include "kernel/search/search.hpp"

#include <cmath>

namespace maxlogdet {

void Search::compare_with_all() noexcept {
  InformationFactor all = at_prior_;
  for (std::size_t i = 0; i < candidates_.count; ++i) {
    if (candidates_.valid[i] != 0) add_rows(static_cast<Index>(i), all);
  }
  for (int c = 0; c < state_dimension; ++c) diagonal_of_all_[c] = 1 / all.inverse()[simd::padded_dimension * c + c];
}

// W_cc L_cc.
double Search::against_all(int c) const noexcept {
  return factor_.inverse()[simd::padded_dimension * c + c] * diagonal_of_all_[c];
}

// In pairs, each scaled by the target, the products leave the range of float64 only where the answer is clear
// (docs/numerics.md); and in one order only, so that a selection ends at the same candidate on every machine. NaN does
// not meet the target.
bool Search::meets_target() const noexcept {
  if (target_efficiency_ == 0) return false;
  double product = 1;
  for (int c = 0; c < state_dimension; c += 2) product *= against_all(c) * against_all(c + 1) * target_efficiency_;
  return product <= 1;
}

double Search::efficiency() const noexcept {
  double root = 1;
  for (int c = 0; c < state_dimension; ++c) root *= std::cbrt(against_all(c));
  return 1 / root;
}

}  // namespace maxlogdet
