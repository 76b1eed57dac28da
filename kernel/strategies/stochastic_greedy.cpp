// SPDX-License-Identifier: MIT
#include "kernel/base/counter_random.hpp"
#include "kernel/strategies/strategies.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace maxlogdet {
namespace {

// s = ceil(n / k ln(1 / epsilon)), at least 1; the last bits of log, which differ between C libraries, do not matter.
double sample_size(std::size_t n, std::size_t k, double epsilon) noexcept {
  const double s = static_cast<double>(n) / static_cast<double>(k) * std::log(1 / epsilon);
  return std::max(1.0, std::ceil(s - 1e-9));
}

// Selects the best of a sample of `size` candidates each, until the deadline if it `has_deadline`.
Status select_from_samples(Search& search, double size, std::uint64_t seed, bool has_deadline) noexcept {
  Screening& screening = search.screening();
  Candidate* const pool = search.pool();  // all that remain; a round moves its sample to the front
  search.list_remaining(pool);
  CounterRandom random(seed);
  screening.layout().make_records();
  while (search.wants_more()) {
    if (has_deadline && search.is_late()) return Status::deadline_reached;
    const std::size_t n = search.remaining();
    const std::size_t s = size < static_cast<double>(n) ? static_cast<std::size_t>(size) : n;
    for (std::size_t j = 0; j < s; ++j) {  // without replacement: the first s steps of a Fisher-Yates shuffle
      std::swap(pool[j], pool[j + random.below(static_cast<std::uint32_t>(n - j))]);
    }
    screening.use_listed(pool, s);
    screening.begin_round(search.answer().factor());
    const Lane chosen = search.find_best();
    screening.end_round();
    search.select(chosen);
    const Candidate candidate = screening.layout().candidate(chosen);
    pool[simd::number(chosen)] = pool[search.remaining()];  // lane j was pool[j]
    if (!search.constraints().has_room(candidate)) {        // its group is full
      const auto is_out = [&](Candidate i) { return !search.constraints().has_room(i); };
      search.close(static_cast<std::size_t>(pool + search.remaining() -
                                            std::remove_if(pool, pool + search.remaining(), is_out)));
    }
  }
  return Status::ok;
}

// A tile.
constexpr double sample_to_fill = 16;

}  // namespace

Status stochastic_greedy(Search& search, const StochasticOptions& options) noexcept {
  const double size = sample_size(search.remaining(), search.missing(), options.epsilon);
  return select_from_samples(search, size, options.seed, true);
}

void fill(Search& search) noexcept { select_from_samples(search, sample_to_fill, 0, false); }

}  // namespace maxlogdet
