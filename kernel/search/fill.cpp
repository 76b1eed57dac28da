// SPDX-License-Identifier: MIT
#include "kernel/information/certificate.hpp"
#include "kernel/search/search.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

// Equal parts of what is missing, each chosen at the information that is then expected: one part alone loses ten times
// as much (docs/performance.md, "Deadlines").
constexpr std::size_t parts = 4;

}  // namespace

// Marks the candidates that may still be selected, and counts them.
void Search::mark_open(unsigned char* flags) noexcept {
  std::copy_n(problem_.is_free, candidates_.count, flags);
  for (std::size_t j = 0; j < answer_.size(); ++j) flags[simd::number(answer_[j])] = 0;
  remaining_ = 0;
  for (std::size_t i = 0; i < candidates_.count; ++i) {
    flags[i] = flags[i] != 0 && constraints_.has_room(static_cast<Candidate>(i)) ? 1 : 0;
    remaining_ += flags[i];
  }
}

// The information to be expected once open candidates drawn at random fill the answer: that of the prior, of all that
// is selected, and of the open ones their share; that of the answer so far where this cannot be factorised.
InformationFactor Search::expected() noexcept {
  constexpr int entries = state_dimension * state_dimension;
  unsigned char* const flags = memory_.is_counted.data();
  double of_open[entries], sum[entries];
  mark_open(flags);
  sum_up(problem_, flags, of_open);
  std::fill_n(flags, candidates_.count, static_cast<unsigned char>(0));
  for (std::size_t j = 0; j < answer_.size(); ++j) flags[simd::number(answer_[j])] = 1;
  sum_up(problem_, flags, sum);
  const double share = remaining_ == 0 ? 0 : static_cast<double>(missing()) / static_cast<double>(remaining_);
  for (int e = 0; e < entries; ++e) sum[e] += share * of_open[e];
  InformationFactor factor;
  return factor.reset(problem_.prior, sum, 0) ? factor : answer_.factor();
}

// In each part those of the largest trace |H W^T|_F^2, as long as their groups have room.
void Search::fill() noexcept {
  unsigned char* const is_open = memory_.is_counted.data();
  double* const traces = memory_.relative_gains.data();
  std::uint32_t* const order = memory_.order.data();
  for (std::size_t part = parts; wants_more(); part = std::max<std::size_t>(part - 1, 1)) {
    candidates_.exact().traces(candidates_.planes, expected().inverse(), candidates_.count, traces);
    mark_open(is_open);
    const std::size_t count = (missing() + part - 1) / part;
    const std::size_t reach = constraints_.has_groups() ? remaining_ : count;
    const std::size_t open = list_by_trace(is_open, candidates_.count, reach, traces, order);
    std::sort(order, order + std::min(reach, open), LargerTrace{traces});
    const std::size_t enough = answer_.size() + count;
    for (std::size_t j = 0; j < std::min(reach, open) && answer_.size() < enough && wants_more(); ++j) {
      const auto candidate = static_cast<Candidate>(order[j]);
      if (!constraints_.has_room(candidate)) continue;
      constraints_.take_room(candidate);
      --remaining_;
      take(candidate);
    }
  }
}

}  // namespace maxlogdet
