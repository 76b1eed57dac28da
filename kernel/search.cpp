// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

#include <cmath>

namespace maxlogdet {

Candidate Search::evaluate(std::size_t begin, std::size_t end) noexcept {
  evaluator.range(factor.inverse(), begin, end, growths);
  Candidate best = no_candidate;
  for (std::size_t i = begin; i < end; ++i) {
    evaluations += eligible[i];
    if (eligible[i] != 0 && growths[i] > best.growth) best = {growths[i], static_cast<std::uint32_t>(i)};
  }
  return best;
}

void Search::select(const Candidate& chosen) noexcept {
  indices[selected] = chosen.index;
  gains[selected] = std::log1p(chosen.growth);
  ++selected;
  --remaining;
  eligible[chosen.index] = 0;
  for (int row = 0; row < candidates.rows(); ++row) {
    double h[state_dimension];
    for (int column = 0; column < state_dimension; ++column) h[column] = candidates.plane(row, column)[chosen.index];
    factor.add_row(h);
  }
}

}  // namespace maxlogdet
