// SPDX-License-Identifier: MIT
#include "kernel/information/information_mixture.hpp"
#include "kernel/information/top_traces.hpp"
#include "kernel/strategies/lazy_greedy.hpp"
#include "kernel/strategies/method.hpp"
#include "kernel/strategies/swaps.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

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

struct RelaxedWorkspace : Workspace {
  explicit RelaxedWorkspace(std::size_t capacity)
      : shortlist(capacity), united(capacity), best_answer(capacity), traces(capacity), swaps(capacity) {}
  std::vector<std::uint32_t> shortlist;    // candidates to search among, in ascending order
  std::vector<std::uint32_t> united;       // the union of the shortlist with others, which replaces it
  std::vector<std::uint32_t> best_answer;  // the best one so far
  TraceMemory traces;
  SwapMemory swaps;
};

// The initial state of a search, to restart it.
class Start {
 public:
  explicit Start(const Search& search) noexcept
      : factor_(search.factor), selected_(search.selected), remaining_(search.remaining) {}

  std::size_t selected() const noexcept { return selected_; }
  std::size_t count_to_select(const Search& search) const noexcept {
    return std::min(search.budget - selected_, remaining_);
  }

  void restore(Search& search) const noexcept {
    search.factor = factor_;
    search.selected = selected_;
    search.remaining = remaining_;
  }

  // Lazy greedy on the listed candidates, in ascending order and at least count_to_select().
  Status search_listed(Search& search, const std::uint32_t* list, std::size_t count) const noexcept {
    restore(search);
    search.screening.restart(search.candidates.largest_of_form);
    search.screening.make_records_of(list, count);
    search.screening.use_listed(list, count);
    return search_lazily(search);
  }

 private:
  InformationFactor factor_;
  std::size_t selected_;
  std::size_t remaining_;
};

// Convex relaxation (D-optimal design), rounded by lazy greedy on the candidates of nonzero weight and a few more
// (docs/performance.md).
class Relaxation {
 public:
  Relaxation(Search& search, RelaxedWorkspace& own) noexcept
      : search_(search),
        own_(own),
        start_(search),
        k_(start_.count_to_select(search)),
        found_(search.indices + start_.selected()) {}

  Status run() noexcept {
    const std::size_t sample = sample_per_selected * k_;
    if (search_.candidates.size() < 2 * sample || k_ == 0) return lazy_greedy(search_);
    const std::size_t listed = list_sample(sample);
    if (listed < sample / 2) return lazy_greedy(search_);
    if (start_.search_listed(search_, own_.shortlist.data(), listed) != Status::ok) return Status::deadline_reached;

    required_ = prior_information(search_.prior_matrix);
    add_blocks(search_.candidates, search_.indices, start_.selected(), required_);
    const Information selected = keep_answer();
    std::copy_n(found_, k_, own_.shortlist.begin());
    std::sort(own_.shortlist.begin(), own_.shortlist.begin() + static_cast<std::ptrdiff_t>(k_));
    const std::size_t count = list_relaxed(selected);
    return count == 0 ? Status::deadline_reached : round(count);
  }

 private:
  // Lists the free candidates of the tiles that begin at multiples of `step`, about `sample` of them if all are free.
  std::size_t list_sample(std::size_t sample) noexcept {
    const std::size_t n = search_.candidates.size();
    const unsigned char* const free = search_.constraints.free();
    const std::size_t step = std::max<std::size_t>(1, n / sample) * simd::tile_size;
    std::size_t count = 0;
    for (std::size_t first = 0; first < n; first += step) {
      for (std::size_t i = first; i < std::min(first + simd::tile_size, n); ++i) {
        own_.shortlist[count] = static_cast<std::uint32_t>(i);
        count += free[i] != 0 ? 1 : 0;
      }
    }
    return count;
  }

  // Makes the answer of the search the best one so far; returns its information.
  Information keep_answer() noexcept {
    std::copy_n(found_, k_, own_.best_answer.begin());
    Information selected = required_;
    add_blocks(search_.candidates, found_, k_, selected);
    return selected;
  }

  // Solves the relaxation, 0 <= w_i <= 1, sum w_i = k, as a mixture of selections: that in the shortlist, of this
  // information, and in each sweep the best one at the information so far. The shortlist becomes the candidates of
  // nonzero weight. Returns how many, a few times k; 0 if the deadline has passed.
  std::size_t list_relaxed(const Information& selected) noexcept {
    const Problem problem = search_.problem();
    std::size_t count = k_;
    float threshold = first_guess(k_);
    InformationMixture mixture;
    bool goes_on = mixture.reset(selected);
    for (int sweep = 0; goes_on && sweep < max_sweeps; ++sweep) {
      if (search_.deadline.has_passed()) return 0;
      const TopTraces top = find_top_traces(problem, mixture.inverse(), k_, threshold, own_.traces);
      threshold = top.threshold;
      count = unite(count, top);
      Information best = required_;
      add_blocks(search_.candidates, top.candidates, top.count, best);
      goes_on = mixture.add(best, max_optimality_gap);
    }
    return count;
  }

  // The shortlist becomes its union with another list; both ascend.
  std::size_t unite(std::size_t count, const TopTraces& top) noexcept {
    const std::uint32_t* const first = own_.shortlist.data();
    std::uint32_t* const united = own_.united.data();
    const std::uint32_t* const end =
        std::set_union(first, first + count, top.candidates, top.candidates + top.count, united);
    own_.shortlist.swap(own_.united);
    return static_cast<std::size_t>(end - united);
  }

  // Lazy greedy and a few swaps in the shortlist; the best answer becomes that of the search.
  Status round(std::size_t count) noexcept {
    Status status = start_.search_listed(search_, own_.shortlist.data(), count);
    if (status == Status::ok) {
      const Information selected = keep_answer();
      status = swap_lowest_traces(search_, own_.best_answer.data(), k_, count - k_, selected, own_.swaps);
    }
    start_.restore(search_);
    for (std::size_t j = 0; j < k_; ++j) search_.add(own_.best_answer[j]);
    search_.remaining -= k_;
    return status;
  }

  Search& search_;
  RelaxedWorkspace& own_;
  Start start_;
  std::size_t k_;
  std::uint32_t* found_;    // the answer of the search after the required candidates
  Information required_{};  // of the prior and the required candidates
};

Status relaxed(Search& search, const Options& /*options*/, Workspace* workspace) noexcept {
  return Relaxation(search, *static_cast<RelaxedWorkspace*>(workspace)).run();
}

}  // namespace

constexpr Method relaxed_method = {relaxed, no_groups_or_targets, 50000, make_workspace<RelaxedWorkspace>};

}  // namespace maxlogdet
