// SPDX-License-Identifier: MIT
#include "kernel/search/fill.hpp"

#include "kernel/information/information.hpp"

#include <algorithm>
#include <numeric>

namespace maxlogdet {
namespace {

using simd::number;

// The information is updated so often while the answer is filled: once is worse (docs/performance.md, "Deadlines").
constexpr std::size_t parts = 4;

class Filling {
 public:
  Filling(Search& search, FillMemory& own, TraceMemory& traces) noexcept
      : search_(search), problem_(search.problem()), answer_(search.answer()), own_(own), traces_(traces) {
    std::copy_n(problem_.is_free, problem_.candidates.count, own_.is_open.data());
    for (std::size_t j = 0; j < answer_.size(); ++j) own_.is_open[number(answer_[j])] = 0;
    close_full_groups();
  }

  void run() noexcept {
    sum_up(problem_, own_.is_open.data(), &sum_.entry[0][0]);
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
    open.is_free = own_.is_open.data();
    open.free_count = search_.remaining();
    const TopTraces top = find_top_traces(open, expected().inverse(), reach, first_guess(search_.missing()), traces_);
    const std::size_t step = std::max<std::size_t>(1, problem_.candidates.count / reach);
    std::size_t count = 0;
    for (std::size_t i = 0; i < problem_.candidates.count; i += step) {
      if (own_.is_open[i] != 0) own_.spread[count++] = static_cast<Candidate>(i);
    }
    const auto end = std::set_union(top.candidates, top.candidates + top.count, own_.spread.data(),
                                    own_.spread.data() + count, own_.shortlist.begin());
    listed_ = static_cast<std::size_t>(end - own_.shortlist.begin());
  }

  // The factor of the information that is to be expected if candidates drawn at random fill the answer; that of the
  // answer so far where it cannot be factorised.
  InformationFactor expected() noexcept {
    add_blocks(problem_.candidates, answer_.candidates() + summed_, answer_.size() - summed_, of_answer_);
    summed_ = answer_.size();
    Information added = of_answer_;
    add_scaled(share_ * static_cast<double>(search_.missing()), sum_, added);
    InformationFactor factor;
    return factor.reset(problem_.prior, &added.entry[0][0], 0) ? factor : answer_.factor();
  }

  // Moves up to `count` candidates of largest trace from the shortlist to the answer.
  void add_best(std::size_t count) noexcept {
    const double* const traces = own_.traces.data();
    problem_.evaluator.traces(expected().inverse(), own_.shortlist.data(), listed_, own_.traces.data());
    std::uint32_t* const order = own_.order.data();
    std::iota(order, order + listed_, 0U);
    const std::size_t sorted = search_.constraints().has_groups() ? listed_ : std::min(count, listed_);
    std::partial_sort(order, order + sorted, order + listed_, [traces](std::uint32_t a, std::uint32_t b) {
      return traces[a] > traces[b] || (traces[a] == traces[b] && a < b);
    });
    const std::size_t enough = answer_.size() + count;
    for (std::size_t j = 0; j < sorted && answer_.size() < enough && search_.wants_more(); ++j) {
      const Candidate candidate = own_.shortlist[order[j]];
      own_.is_open[number(candidate)] = 0;
      if (search_.constraints().has_room(candidate)) search_.add(candidate);
    }
    const auto is_closed = [this](Candidate i) { return own_.is_open[number(i)] == 0; };
    const auto end = own_.shortlist.begin() + static_cast<std::ptrdiff_t>(listed_);
    listed_ = static_cast<std::size_t>(std::remove_if(own_.shortlist.begin(), end, is_closed) - own_.shortlist.begin());
  }

  // Closes the open candidates whose group is full.
  void close_full_groups() noexcept {
    if (!search_.constraints().has_groups()) return;
    std::size_t open = 0;
    for (std::size_t i = 0; i < problem_.candidates.count; ++i) {
      if (!search_.constraints().has_room(static_cast<Candidate>(i))) own_.is_open[i] = 0;
      open += own_.is_open[i];
    }
    search_.close(search_.remaining() - open);
  }

  Search& search_;
  const Problem& problem_;
  const Answer& answer_;
  FillMemory& own_;
  TraceMemory& traces_;
  std::size_t listed_ = 0;
  Information sum_{};        // of all open candidates
  double share_ = 0;         // of each in it
  Information of_answer_{};  // without the prior
  std::size_t summed_ = 0;   // entries of the answer in it
};

}  // namespace

void fill(Search& search, FillMemory& own, TraceMemory& traces) noexcept {
  if (search.wants_more()) Filling(search, own, traces).run();
}

}  // namespace maxlogdet
