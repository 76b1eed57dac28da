// SPDX-License-Identifier: MIT
#include "kernel/blocks/stored_rows.hpp"
#include "kernel/information/certificate.hpp"
#include "kernel/search/search.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

// Equal parts of what is missing, each chosen at the information that is then expected. Of 2000 matches one part alone
// loses up to 4 nats, two lose 0.1.
constexpr std::size_t parts = 2;

// sum <- sum + H^T H.
void add_square(const Candidates& candidates, Candidate candidate, double* sum) noexcept {
  constexpr int n = state_dimension;
  double rows[max_block_rows][n];
  read_rows(candidates, candidate, rows);
  for (int row = 0; row < candidates.rows; ++row) {
    for (int e = 0; e < n * n; ++e) sum[e] += rows[row][e / n] * rows[row][e % n];
  }
}

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

// In each part those of the largest trace |H W^T|_F^2, as long as their groups have room. W is of the information to be
// expected once open candidates drawn at random fill the answer: that of the prior, of all that is selected, and of the
// open ones their share; that of the answer so far where this cannot be factorised.
void Search::fill() noexcept {
  constexpr int entries = state_dimension * state_dimension;
  unsigned char* const flags = memory_.is_counted.data();
  double* const traces = memory_.relative_gains.data();
  std::uint32_t* const order = memory_.order.data();
  double of_open[entries], of_answer[entries];
  std::fill_n(flags, candidates_.count, static_cast<unsigned char>(0));
  for (std::size_t j = 0; j < answer_.size(); ++j) flags[simd::number(answer_[j])] = 1;
  sum_up(problem_, flags, of_answer);
  mark_open(flags);
  sum_up(problem_, flags, of_open);
  const double share = 1 / static_cast<double>(std::max<std::size_t>(remaining_, 1));
  for (std::size_t part = parts; wants_more(); part = std::max<std::size_t>(part - 1, 1)) {
    double expected[entries];
    for (int e = 0; e < entries; ++e) expected[e] = of_answer[e] + share * static_cast<double>(missing()) * of_open[e];
    InformationFactor factor;
    if (!factor.reset(problem_.prior, expected, 0)) factor = answer_.factor();
    candidates_.exact().traces(candidates_.planes, factor.inverse(), candidates_.count, traces);

    const std::size_t count = (missing() + part - 1) / part;
    const std::size_t reach = constraints_.has_groups() ? remaining_ : count;
    const std::size_t listed = std::min(reach, list_by_trace(flags, candidates_.count, reach, traces, order));
    std::sort(order, order + listed, LargerTrace{traces});
    const std::size_t enough = answer_.size() + count;
    for (std::size_t j = 0; j < listed && answer_.size() < enough && wants_more(); ++j) {
      const auto candidate = static_cast<Candidate>(order[j]);
      if (!constraints_.has_room(candidate)) continue;
      constraints_.take_room(candidate);
      take(candidate);
      add_square(candidates_, candidate, of_answer);
    }
    mark_open(flags);
  }
}

}  // namespace maxlogdet
