// SPDX-License-Identifier: MIT
#include "kernel/search/fill.hpp"

#include "kernel/information/information.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace maxlogdet {
namespace {

// The information is updated so often while the answer is filled: once is worse (docs/performance.md, "Deadlines").
constexpr std::size_t parts = 4;

class Filling {
 public:
  Filling(Search& search, TraceMemory& memory) noexcept
      : search_(search),
        memory_(memory),
        open_(search.memory.is_counted.data()),
        shortlist_(search.memory.decisions.candidates.data()) {
    std::copy_n(search.constraints.free(), search.candidates.size(), open_);
    for (std::size_t j = 0; j < search.selected; ++j) open_[search.indices[j]] = 0;
    close_full_groups();
  }

  void run() noexcept {
    const std::size_t before = search_.selected;
    search_.sum_up(open_, &sum_.entry[0][0]);
    share_ = 1 / static_cast<double>(search_.remaining);
    for (std::size_t reach = missing(); search_.wants_more(); reach *= 2) {  // again only if groups are full
      list(reach);
      for (std::size_t part = parts; part > 0 && search_.wants_more(); --part) {
        add_best((missing() + part - 1) / part);
      }
      close_full_groups();
    }
    search_.filled = search_.selected - before;
  }

 private:
  std::size_t missing() const noexcept { return std::min(search_.budget - search_.selected, search_.remaining); }

  // Shortlists, in ascending order, the open candidates of largest trace, and about as many at equal distances: the
  // former may all be alike.
  void list(std::size_t reach) noexcept {
    Problem problem = search_.problem();
    problem.is_free = open_;
    problem.free_count = search_.remaining;
    const TopTraces top = find_top_traces(problem, expected().inverse(), reach, first_guess(missing()), memory_);
    std::uint32_t* const spread = search_.memory.decisions.lanes.data();
    const std::size_t step = std::max<std::size_t>(1, search_.candidates.size() / reach);
    std::size_t count = 0;
    for (std::size_t i = 0; i < search_.candidates.size(); i += step) {
      if (open_[i] != 0) spread[count++] = static_cast<std::uint32_t>(i);
    }
    const std::uint32_t* const end =
        std::set_union(top.candidates, top.candidates + top.count, spread, spread + count, shortlist_);
    listed_ = static_cast<std::size_t>(end - shortlist_);
  }

  // The factor of the information that is to be expected if candidates drawn at random fill the answer; that of the
  // answer so far where it cannot be factorised.
  InformationFactor expected() noexcept {
    add_blocks(search_.candidates, search_.indices + summed_, search_.selected - summed_, answer_);
    summed_ = search_.selected;
    Information added = answer_;
    add_scaled(share_ * static_cast<double>(missing()), sum_, added);
    InformationFactor factor;
    return factor.reset(search_.prior_matrix, &added.entry[0][0], 0) ? factor : search_.factor;
  }

  // Moves up to `count` candidates of largest trace from the shortlist to the answer.
  void add_best(std::size_t count) noexcept {
    double* const traces = search_.memory.decisions.relative_gains.data();
    search_.evaluator.exact_traces(expected().inverse(), shortlist_, listed_, traces);
    std::uint32_t* const order = search_.memory.decisions.order.data();
    std::iota(order, order + listed_, 0U);
    const std::size_t sorted = search_.constraints.has_groups() ? listed_ : std::min(count, listed_);
    std::partial_sort(order, order + sorted, order + listed_, [traces](std::uint32_t a, std::uint32_t b) {
      return traces[a] > traces[b] || (traces[a] == traces[b] && a < b);
    });
    const std::size_t enough = search_.selected + count;
    for (std::size_t j = 0; j < sorted && search_.selected < enough && search_.wants_more(); ++j) {
      add(shortlist_[order[j]]);
    }
    const auto is_closed = [this](std::uint32_t i) { return open_[i] == 0; };
    listed_ = static_cast<std::size_t>(std::remove_if(shortlist_, shortlist_ + listed_, is_closed) - shortlist_);
  }

  void add(std::uint32_t candidate) noexcept {
    open_[candidate] = 0;
    if (!search_.constraints.has_room(candidate)) return;
    search_.add(candidate);
    search_.constraints.take_room(candidate);
    --search_.remaining;
  }

  // Counts the open candidates after closing those whose group is full.
  void close_full_groups() noexcept {
    if (!search_.constraints.has_groups()) return;
    search_.remaining = 0;
    for (std::size_t i = 0; i < search_.candidates.size(); ++i) {
      if (!search_.constraints.has_room(static_cast<std::uint32_t>(i))) open_[i] = 0;
      search_.remaining += open_[i];
    }
  }

  Search& search_;
  TraceMemory& memory_;
  unsigned char* open_;       // per candidate: 1 if it may still be selected
  std::uint32_t* shortlist_;  // candidates to add, in ascending order
  std::size_t listed_ = 0;
  Information sum_{};       // of all open candidates
  double share_ = 0;        // of each in it
  Information answer_{};    // of the answer, without the prior
  std::size_t summed_ = 0;  // entries of the answer in it
};

}  // namespace

void fill(Search& search, TraceMemory& memory) noexcept {
  if (search.wants_more()) Filling(search, memory).run();
}

}  // namespace maxlogdet
