// SPDX-License-Identifier: MIT
#include "kernel/information/information_mixture.hpp"
#include "kernel/information/top_traces.hpp"
#include "kernel/strategies/lazy_greedy.hpp"
#include "kernel/strategies/method.hpp"
#include "kernel/strategies/swaps.hpp"

#include <algorithm>
#include <utility>

namespace maxlogdet {
namespace {

// Size of the initial sample, per candidate to select: lazy greedy on it gives the relaxation an information that
// observes the whole state.
constexpr std::size_t sample_per_selected = 8;
// Maximum number of Frank-Wolfe sweeps: with eight, one clustered frame in three thousand lost 2e-3 nats, with six one
// in three hundred up to 6e-3.
constexpr int max_sweeps = 12;
// The distance from its optimum, nats, at which a relaxation stops: rounding it costs more. Most frames reach it after
// 4 sweeps.
constexpr double max_optimality_gap = 5e-3;

// Convex relaxation (D-optimal design), rounded by lazy greedy on the candidates of nonzero weight and a few more
// (docs/performance.md).
class Relaxation {
 public:
  Relaxation(Search& search, StrategyMemory& memory) noexcept
      : search_(search),
        problem_(search.problem()),
        shortlist_(memory.shortlist),
        united_(memory.united),
        best_answer_(memory.answer),
        traces_(memory.traces),
        k_(search.missing()) {}

  Status run() noexcept {
    const std::size_t sample = sample_per_selected * k_;
    if (problem_.candidates.count < 2 * sample || k_ == 0) return lazy_greedy(search_);
    const std::size_t listed = list_sample(sample);
    if (listed < sample / 2) return lazy_greedy(search_);
    if (search_shortlist(listed) != Status::ok) return Status::deadline_reached;

    required_ =
        plus_blocks(problem_.candidates, problem_.required, problem_.required_count, prior_information(problem_.prior));
    const Information selected = keep_answer();
    std::copy_n(best_answer_, k_, shortlist_);
    std::sort(shortlist_, shortlist_ + k_);
    const std::size_t count = list_relaxed(selected);
    return count == 0 ? Status::deadline_reached : search_and_swap(count);
  }

 private:
  // Lists the free candidates of the tiles that begin at multiples of `step`, about `sample` of them if all are free.
  std::size_t list_sample(std::size_t sample) noexcept {
    const std::size_t n = problem_.candidates.count;
    const std::size_t step = std::max<std::size_t>(1, n / sample) * simd::tile_size;
    std::size_t count = 0;
    for (std::size_t first = 0; first < n; first += step) {
      for (std::size_t i = first; i < std::min(first + simd::tile_size, n); ++i) {
        shortlist_[count] = static_cast<Candidate>(i);
        count += problem_.is_free[i] != 0 ? 1 : 0;
      }
    }
    return count;
  }

  // Lazy greedy among the first `count` of the shortlist, at least k, from the required candidates on.
  Status search_shortlist(std::size_t count) noexcept {
    search_.restart_with(nullptr, 0);
    search_.screening().layout().make_records_of(shortlist_, count);
    search_.screening().use_listed(shortlist_, count);
    return search_lazily(search_);
  }

  // Makes the answer of the search the best one so far; returns its information.
  Information keep_answer() noexcept {
    std::copy_n(search_.answer().candidates() + problem_.required_count, k_, best_answer_);
    return plus_blocks(problem_.candidates, best_answer_, k_, required_);
  }

  // Solves the relaxation, 0 <= w_i <= 1, sum w_i = k, as a mixture of selections: that in the shortlist, of this
  // information, and in each sweep the best one at the information so far. The shortlist becomes the candidates of
  // nonzero weight. Returns how many, a few times k; 0 if the deadline has passed.
  std::size_t list_relaxed(const Information& selected) noexcept {
    std::size_t count = k_;
    float threshold = first_guess(k_);
    InformationMixture mixture;
    bool goes_on = mixture.reset(selected);
    for (int sweep = 0; goes_on && sweep < max_sweeps; ++sweep) {
      if (search_.is_late()) return 0;
      const TopTraces top = find_top_traces(problem_, mixture.inverse(), k_, threshold, traces_);
      threshold = top.threshold;
      count = unite(count, top);
      goes_on = mixture.add(plus_blocks(problem_.candidates, top.candidates, top.count, required_), max_optimality_gap);
    }
    return count;
  }

  // The shortlist becomes its union with another list; both ascend.
  std::size_t unite(std::size_t count, const TopTraces& top) noexcept {
    const Candidate* const end =
        std::set_union(shortlist_, shortlist_ + count, top.candidates, top.candidates + top.count, united_);
    std::swap(shortlist_, united_);
    return static_cast<std::size_t>(end - shortlist_);
  }

  // Lazy greedy and a few swaps in the shortlist; the best answer becomes that of the search.
  Status search_and_swap(std::size_t count) noexcept {
    Status status = search_shortlist(count);
    if (status == Status::ok) {
      const Information selected = keep_answer();
      status = swap_lowest_traces(search_, best_answer_, k_, count - k_, selected, traces_);
    }
    search_.restart_with(best_answer_, k_);
    return status;
  }

  Search& search_;
  const Problem& problem_;
  Candidate* shortlist_;    // candidates to search among, in ascending order
  Candidate* united_;       // the union of the shortlist with others, which replaces it
  Candidate* best_answer_;  // the best one so far, without what is required
  TraceMemory& traces_;
  std::size_t k_;
  Information required_{};  // of the prior and the required candidates
};

Status relaxed(Search& search, const Options& /*options*/, StrategyMemory& memory) noexcept {
  return Relaxation(search, memory).run();
}

}  // namespace

constexpr Method relaxed_method = {relaxed, no_groups_or_targets, 50000};

}  // namespace maxlogdet
