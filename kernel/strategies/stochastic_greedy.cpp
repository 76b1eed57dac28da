// SPDX-License-Identifier: MIT
#include "kernel/strategies/method.hpp"
#include "simd/counter_random.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace maxlogdet {
namespace {

// s = ceil(n / k ln(1 / epsilon)), at least 1; the last bits of log, which differ between C libraries, do not matter.
double sample_size(std::size_t n, std::size_t k, double epsilon) noexcept {
  const double s = static_cast<double>(n) / static_cast<double>(k) * std::log(1 / epsilon);
  return std::max(1.0, std::ceil(s - 1e-9));
}

// Algorithm 1 of the paper: in each round the best of a random sample of s = ceil(n / k ln(1 / epsilon)).
Status stochastic_greedy(Search& search, const Options& options, StrategyMemory& memory) noexcept {
  const Problem& problem = search.problem();
  Screening& screening = search.screening();
  Candidate* const pool = memory.shortlist;          // all that remain; a round moves its sample to the front
  std::uint32_t* const draws = memory.traces.order;  // offsets of a round's Fisher-Yates shuffle
  const std::size_t filled = list_flagged(problem.is_free, problem.candidates.count, pool);
  const double full_sample = sample_size(filled, search.missing(), options.stochastic.epsilon);
  const std::uint64_t key = CounterRandom(options.stochastic.seed).key();
  std::uint64_t drawn = 0;
  screening.layout().make_records(problem.candidates.count);

  while (search.wants_more()) {
    if (search.is_late()) return Status::deadline_reached;
    const std::size_t s = full_sample < static_cast<double>(search.remaining()) ? static_cast<std::size_t>(full_sample)
                                                                                : search.remaining();
    // Without replacement: the first s steps of a Fisher-Yates shuffle.
    problem.evaluator.kernel().draw(key, drawn + 1, static_cast<std::uint32_t>(search.remaining()), s, draws);
    for (std::size_t j = 0; j < s; ++j) std::swap(pool[j], pool[j + draws[j]]);
    drawn += s;
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

Error check_epsilon(const Options& options) noexcept {
  return options.stochastic.epsilon > 0 && options.stochastic.epsilon < 1 ? Error::none : Error::invalid_epsilon;
}

}  // namespace

constexpr Method stochastic_greedy_method = {stochastic_greedy, check_epsilon, one_thread_only};

}  // namespace maxlogdet
