// SPDX-License-Identifier: MIT
#include "kernel/strategies/method.hpp"
#include "simd/counter_random.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maxlogdet {
namespace {

// s = ceil(n / k ln(1 / epsilon)), at least 1; the last bits of log, which differ between C libraries, do not matter.
double sample_size(std::size_t n, std::size_t k, double epsilon) noexcept {
  const double s = static_cast<double>(n) / static_cast<double>(k) * std::log(1 / epsilon);
  return std::max(1.0, std::ceil(s - 1e-9));
}

struct StochasticWorkspace : Workspace {
  explicit StochasticWorkspace(std::size_t capacity) : pool(capacity), draws(capacity) {}
  std::vector<std::uint32_t> pool;   // candidates that remain; a round moves its sample to the front
  std::vector<std::uint32_t> draws;  // offsets of a round's Fisher-Yates shuffle
};

// Algorithm 1 of the paper: in each round the best of a random sample of s = ceil(n / k ln(1 / epsilon)).
Status stochastic_greedy(Search& search, const Options& options, Workspace* workspace) noexcept {
  auto& own = *static_cast<StochasticWorkspace*>(workspace);
  std::uint32_t* const pool = own.pool.data();
  std::uint32_t* const draws = own.draws.data();
  std::size_t filled = 0;
  for (std::size_t i = 0; i < search.candidates.size(); ++i) {
    if (search.constraints.free()[i] != 0) pool[filled++] = static_cast<std::uint32_t>(i);
  }
  const double full_sample =
      sample_size(filled, std::min(filled, search.budget - search.selected), options.stochastic.epsilon);
  const std::uint64_t key = CounterRandom(options.stochastic.seed).key();
  std::uint64_t drawn = 0;
  search.screening.make_records(search.candidates.size());

  while (search.wants_more()) {
    if (search.deadline.has_passed()) return Status::deadline_reached;
    const std::size_t s =
        full_sample < static_cast<double>(search.remaining) ? static_cast<std::size_t>(full_sample) : search.remaining;
    // Without replacement: the first s steps of a Fisher-Yates shuffle.
    search.kernel.draw(key, drawn + 1, static_cast<std::uint32_t>(search.remaining), s, draws);
    for (std::size_t j = 0; j < s; ++j) std::swap(pool[j], pool[j + draws[j]]);
    drawn += s;
    search.screening.use_listed(pool, s);
    search.screening.begin_round(search.factor);
    search.screening.evaluate_all();
    const std::size_t chosen = search.select_best();  // lane j is pool[j]
    const std::uint32_t candidate = pool[chosen];
    pool[chosen] = pool[search.remaining];
    if (!search.constraints.has_room(candidate)) {  // its group is full
      const auto is_out = [&](std::uint32_t i) { return !search.constraints.has_room(i); };
      search.remaining = static_cast<std::size_t>(std::remove_if(pool, pool + search.remaining, is_out) - pool);
    }
  }
  return Status::ok;
}

Error check_epsilon(const Options& options) noexcept {
  return options.stochastic.epsilon > 0 && options.stochastic.epsilon < 1 ? Error::none : Error::invalid_epsilon;
}

}  // namespace

constexpr Method stochastic_greedy_method = {stochastic_greedy, check_epsilon, one_thread_only,
                                             make_workspace<StochasticWorkspace>};

}  // namespace maxlogdet
