// SPDX-License-Identifier: MIT
#include "kernel/base/counter_random.hpp"
#include "kernel/search/search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace maxlogdet {

Status greedy(Search& search) noexcept {
  search.screen_all();
  while (search.wants_more()) {
    if (search.is_late()) return Status::deadline_reached;
    search.select(search.find_best());
  }
  return Status::ok;
}

// Until the selected rows span the state, gains are those against the prior and predict later ones poorly; so at least
// three rounds evaluate every candidate. The round after them does so once more, and the candidates are ordered by its
// gains, which takes about as long as a round.
Status lazy_greedy(Search& search) noexcept {
  const int rows = std::max(search.rows(), 1);
  const std::size_t spanned = search.size() + static_cast<std::size_t>(std::max(3, state_dimension / rows));
  search.screen_all();
  while (search.wants_more()) {
    if (search.is_late()) return Status::deadline_reached;
    const bool is_order_due = !search.is_ordered() && search.size() >= spanned;
    search.select(search.find_best());
    if (!is_order_due || !search.wants_more()) continue;
    if (search.is_late()) return Status::deadline_reached;
    search.order_by_gain();
  }
  return Status::ok;
}

namespace {

// s = ceil(n / k ln(1 / epsilon)), at least 1; the last bits of log, which differ between C libraries, do not matter.
double sample_size(std::size_t n, std::size_t k, double epsilon) noexcept {
  const double s = static_cast<double>(n) / static_cast<double>(k) * std::log(1 / epsilon);
  return std::max(1.0, std::ceil(s - 1e-9));
}

// Selects the best of a sample of `size` candidates each, until the deadline if it `has_deadline`.
Status select_from_samples(Search& search, double size, std::uint64_t seed, bool has_deadline) noexcept {
  Index* const pool = search.list_remaining();  // a round moves its sample to the front
  CounterRandom random(seed);
  while (search.wants_more()) {
    if (has_deadline && search.is_late()) return Status::deadline_reached;
    const std::size_t n = search.remaining();
    const std::size_t s = size < static_cast<double>(n) ? static_cast<std::size_t>(size) : n;
    for (std::size_t j = 0; j < s; ++j) {  // without replacement: the first s steps of a Fisher-Yates shuffle
      std::swap(pool[j], pool[j + random.below(static_cast<std::uint32_t>(n - j))]);
    }
    search.screen(pool, s);
    const Lane chosen = search.find_best();
    const Index candidate = search.candidate(chosen);
    search.select(chosen);
    pool[simd::number(chosen)] = pool[search.remaining()];  // lane j was pool[j]
    if (!search.has_room(candidate)) search.drop_closed(pool);
  }
  return Status::ok;
}

}  // namespace

Status stochastic_greedy(Search& search, const StochasticOptions& options) noexcept {
  const double size = sample_size(search.remaining(), search.missing(), options.epsilon);
  return select_from_samples(search, size, options.seed, true);
}

void fill(Search& search) noexcept { select_from_samples(search, simd::tile_size, 0, false); }

}  // namespace maxlogdet
