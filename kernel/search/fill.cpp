// SPDX-License-Identifier: MIT
#include "kernel/search/fill.hpp"

#include "kernel/information/information.hpp"

#include <algorithm>
#include <functional>

namespace maxlogdet {
namespace {

// The information is updated so often while the answer is filled: once is worse (docs/performance.md, "Deadlines").
constexpr std::size_t parts = 4;

class Filling {
 public:
  Filling(Search& search, StrategyMemory& memory) noexcept
      : search_(search),
        problem_(search.problem()),
        answer_(search.answer()),
        memory_(memory),
        is_open_(memory.remains),
        shortlist_(memory.shortlist) {
    mark_unselected(search, is_open_);
    close_full_groups();
  }

  void run() noexcept {
    sum_up(problem_, is_open_.data(), &sum_.entry[0][0]);
    share_ = 1 / static_cast<double>(search_.remaining());
    for (std::size_t reach = search_.missing(); search_.wants_more(); reach *= 2) {  // again only if groups are full
      list(reach);
      for (std::size_t part = parts; part > 0 && search_.wants_more(); --part) {
        add_best((search_.missing() + part - 1) / part);
      }
      close_full_groups();
    }
  }

 private:
  // Shortlists, in ascending order, the open candidates of largest trace, and about as many at equal distances: the
  // former may all be alike.
  void list(std::size_t reach) noexcept {
    Problem open = problem_;
    open.is_free = is_open_.data();
    open.free_count = search_.remaining();
    const TopTraces top =
        find_top_traces(open, expected().inverse(), reach, first_guess(search_.missing()), memory_.traces);
    const std::size_t step = std::max<std::size_t>(1, problem_.candidates.count / reach);
    Candidate* const spread = memory_.united;
    Candidate* end_of_spread = spread;
    for (std::size_t i = 0; i < problem_.candidates.count; i += step) {
      const auto candidate = static_cast<Candidate>(i);
      if (is_open_[candidate] != 0) *end_of_spread++ = candidate;
    }
    auto* const end = std::set_union(top.candidates, top.candidates + top.count, spread, end_of_spread, shortlist_);
    listed_ = static_cast<std::size_t>(end - shortlist_);
  }

  // The factor of the information that is to be expected if candidates drawn at random fill the answer; that of the
  // answer so far where it cannot be factorised.
  InformationFactor expected() noexcept {
    of_answer_ = plus_blocks(problem_.candidates, answer_.candidates() + summed_, answer_.size() - summed_, of_answer_);
    summed_ = answer_.size();
    Information added = of_answer_;
    add_scaled(share_ * static_cast<double>(search_.missing()), sum_, added);
    InformationFactor factor;
    return factor.reset(problem_.prior, &added.entry[0][0], 0) ? factor : answer_.factor();
  }

  // Moves up to `count` candidates of largest trace from the shortlist to the answer.
  void add_best(std::size_t count) noexcept {
    const std::size_t sorted = search_.constraints().has_groups() ? listed_ : std::min(count, listed_);
    order_by_trace(problem_, expected().inverse(), shortlist_, listed_, sorted, std::greater<>(), memory_.traces);
    const std::size_t enough = answer_.size() + count;
    for (std::size_t j = 0; j < sorted && answer_.size() < enough && search_.wants_more(); ++j) {
      const Candidate candidate = shortlist_[memory_.traces.order[j]];
      is_open_[candidate] = 0;
      if (search_.constraints().has_room(candidate)) search_.add(candidate);
    }
    const auto is_closed = [this](Candidate i) { return is_open_[i] == 0; };
    listed_ = static_cast<std::size_t>(std::remove_if(shortlist_, shortlist_ + listed_, is_closed) - shortlist_);
  }

  // Closes the open candidates whose group is full.
  void close_full_groups() noexcept {
    if (!search_.constraints().has_groups()) return;
    std::size_t open = 0;
    for (std::size_t i = 0; i < problem_.candidates.count; ++i) {
      const auto candidate = static_cast<Candidate>(i);
      if (!search_.constraints().has_room(candidate)) is_open_[candidate] = 0;
      open += is_open_[candidate];
    }
    search_.close(search_.remaining() - open);
  }

  Search& search_;
  const Problem& problem_;
  const Answer& answer_;
  StrategyMemory& memory_;
  ArrayOf<Candidate, unsigned char>& is_open_;  // whether it may still be selected
  Candidate* shortlist_;                        // candidates to add, in ascending order
  std::size_t listed_ = 0;
  Information sum_{};        // of all open candidates
  double share_ = 0;         // of each in it
  Information of_answer_{};  // without the prior
  std::size_t summed_ = 0;   // entries of the answer in it
};

}  // namespace

void fill(Search& search, StrategyMemory& memory) noexcept {
  if (search.wants_more()) Filling(search, memory).run();
}

}  // namespace maxlogdet
