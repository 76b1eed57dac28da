// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet {

// bounds[t] is an upper bound of every gain that remains in tile t: its largest gain when it was last evaluated,
// raised by the rounding error that gain may carry. A tile is skipped only if its bound, raised once more by the error
// that today's gains may carry, is below the best gain found this round; so rounding cannot make it differ from greedy.
Status lazy_greedy(Search& search) noexcept {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::size_t n = search.candidates.size();
  const std::size_t tiles = (n + tile_size - 1) / tile_size;
  double* const bounds = search.bounds;
  std::fill_n(bounds, tiles, infinity);

  while (search.wants_more()) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    const double error = search.factor.gain_error(search.candidates.max_row_norm());
    const double slack = std::exp(error);
    const auto raised = [slack](double growth) {  // of a determinant that is larger by a factor exp(error)
      return slack < infinity ? growth * slack + (slack - 1) : infinity;
    };

    const auto evaluate_tile = [&](std::size_t tile) {
      const std::size_t begin = tile * tile_size;
      const Candidate best = search.evaluate(begin, std::min(begin + tile_size, n));
      bounds[tile] = raised(best.growth);
      return best;
    };

    const auto most_promising = static_cast<std::size_t>(std::max_element(bounds, bounds + tiles) - bounds);
    Candidate best = evaluate_tile(most_promising);
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      if (tile == most_promising || raised(bounds[tile]) < best.growth) continue;
      const Candidate candidate = evaluate_tile(tile);
      if (candidate.is_better_than(best)) best = candidate;
    }
    search.select(best);
  }
  return Status::ok;
}

}  // namespace maxlogdet
