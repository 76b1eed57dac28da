// SPDX-License-Identifier: MIT
#include "kernel/information/information_mixture.hpp"
#include "kernel/information/top_traces.hpp"
#include "kernel/strategies/method.hpp"
#include "kernel/strategies/swaps.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

// Candidates to start from, by budget: lazy greedy on these gives the relaxation an information that observes the whole
// state.
constexpr std::size_t sample_per_selected = 8;
// Frank-Wolfe sweeps at most: with eight, one clustered frame in three thousand lost 2e-3 nats, with six one in three
// hundred up to 6e-3.
constexpr int max_sweeps = 12;
// Nats from its optimum at which a relaxation is good enough: rounding it costs more. Most frames are there after 4.
constexpr double enough = 5e-3;

// What a search starts from, to start again.
class Start {
 public:
  explicit Start(const Search& search) noexcept
      : factor_(search.factor), selected_(search.selected), remaining_(search.remaining) {}

  std::size_t selected() const noexcept { return selected_; }
  std::size_t wanted(const Search& search) const noexcept { return std::min(search.budget - selected_, remaining_); }

  void restore(Search& search) const noexcept {
    search.factor = factor_;
    search.selected = selected_;
    search.remaining = remaining_;
  }

  // Lazy greedy on listed candidates, in ascending order, at least as many as are wanted.
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

// Lists the free candidates of every so manieth tile, `wanted` of them if all are free.
std::size_t list_sample(Search& search, std::size_t wanted) noexcept {
  const std::size_t n = search.candidates.size();
  const unsigned char* const free = search.constraints.free();
  const std::size_t step = std::max<std::size_t>(1, n / wanted) * simd::tile_size;
  std::size_t count = 0;
  for (std::size_t first = 0; first < n; first += step) {
    for (std::size_t i = first; i < std::min(first + simd::tile_size, n); ++i) {
      search.pool[count] = static_cast<std::uint32_t>(i);
      count += free[i] != 0 ? 1 : 0;
    }
  }
  return count;
}

// The pool becomes its union with another list; both ascend.
std::size_t unite(Search& search, std::size_t count, const std::uint32_t* list, std::size_t size) noexcept {
  std::uint32_t* const end = std::set_union(search.pool, search.pool + count, list, list + size, search.lanes);
  std::copy(search.lanes, end, search.pool);
  return static_cast<std::size_t>(end - search.lanes);
}

// The relaxation, 0 <= w_i <= 1, sum w_i = k, as a mixture of selections: one in the pool, of this information, and
// those that each sweep finds best at the information so far. What they hold is all that has a weight; it is listed in
// the pool. Returns how many, a few times k; 0 if the deadline passed.
std::size_t list_relaxed(Search& search, const Information& required, const Information& selected,
                         std::size_t wanted) noexcept {
  std::size_t count = wanted;
  float threshold = first_guess(wanted);
  InformationMixture mixture;
  bool goes_on = mixture.reset(selected);
  for (int sweep = 0; goes_on && sweep < max_sweeps; ++sweep) {
    if (search.deadline.has_passed()) return 0;
    const TopTraces top = find_top_traces(search, mixture.inverse(), wanted, threshold);
    threshold = top.threshold;
    count = unite(search, count, top.candidates, top.count);
    Information best = required;
    add_blocks(search.candidates, top.candidates, top.count, best);
    goes_on = mixture.add(best, enough);
  }
  return count;
}

// Convex relaxation (D-optimal design), rounded by lazy greedy on the candidates that it gives weight to and a few more
// (docs/performance.md).
Status relaxed(Search& search, const Options& /*options*/) noexcept {
  const Start start(search);
  const std::size_t wanted = start.wanted(search);
  const std::size_t sample = sample_per_selected * wanted;
  if (search.candidates.size() < 2 * sample || wanted == 0) return lazy_greedy(search);
  const std::size_t listed = list_sample(search, sample);
  if (listed < sample / 2) return lazy_greedy(search);
  if (start.search_listed(search, search.pool, listed) != Status::ok) return Status::deadline_reached;

  Information required = prior_information(search.prior_matrix);
  add_blocks(search.candidates, search.indices, start.selected(), required);
  std::uint32_t* const found = search.indices + start.selected();
  std::uint32_t* const answer = search.draws;  // the best so far
  std::copy_n(found, wanted, answer);
  Information selected = required;
  add_blocks(search.candidates, found, wanted, selected);
  std::copy_n(found, wanted, search.pool);
  std::sort(search.pool, search.pool + wanted);
  const std::size_t count = list_relaxed(search, required, selected, wanted);
  if (count == 0) return Status::deadline_reached;

  Status status = start.search_listed(search, search.pool, count);
  if (status == Status::ok) {
    selected = required;
    add_blocks(search.candidates, found, wanted, selected);
    status = swap_least_valuable(search, found, wanted, count - wanted, selected);
    std::copy_n(found, wanted, answer);
  }
  start.restore(search);
  for (std::size_t j = 0; j < wanted; ++j) search.add(answer[j]);
  search.remaining -= wanted;
  return status;
}

}  // namespace

constexpr Method relaxed_method = {relaxed, no_groups_or_targets, 50000};

}  // namespace maxlogdet
