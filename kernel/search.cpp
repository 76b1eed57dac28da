// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

#include "kernel/stored_rows.hpp"

#include <cmath>

namespace maxlogdet {

std::size_t Search::select_best() noexcept {
  const std::size_t count = screening.survivors(lanes);
  std::size_t best = 0;
  for (std::size_t j = 0; j < count; ++j) contenders[j] = screening.candidate(lanes[j]);
  if (count > 1) {
    evaluator.decide(factor.inverse(), contenders, count, growths);
    float64_decisions += count;
    for (std::size_t j = 1; j < count; ++j) {
      const bool ties = growths[j] == growths[best];
      if (growths[j] > growths[best] || (ties && contenders[j] < contenders[best])) best = j;
    }
  }
  const std::uint32_t chosen = contenders[best];
  double h[max_block_rows][state_dimension];
  read_rows(candidates, chosen, h);
  const double growth = factor.add_block(kernel, h, candidates.rows());
  indices[selected] = chosen;
  gains[selected] = std::log1p(growth);
  ++selected;
  --remaining;
  screening.remove(lanes[best]);
  return lanes[best];
}

}  // namespace maxlogdet
