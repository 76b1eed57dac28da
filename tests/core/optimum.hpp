// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/request.hpp"
#include "tests/support/triangle.hpp"

#include <algorithm>
#include <map>

namespace maxlogdet::test {

/// The largest log det of at most `budget` candidates, those required included, by trying every subset of what
/// constraints leave. With `keeps_to_groups` they also leave room to each other; without, only the required ones take
/// room.
class Optimum {
 public:
  Optimum(const Problem& problem, bool keeps_to_groups) : problem_(problem), keeps_to_groups_(keeps_to_groups) {}

  long double of(std::size_t budget) {
    Triangle information(problem_.information());
    for (std::size_t i = 0; i < problem_.blocks.size(); ++i) {
      if (!problem_.is_required(i)) continue;
      information.add(stored_block(problem_.blocks, i));
      ++taken_[problem_.group_of(i)];
    }
    return descend(0, budget - problem_.required_count(), information);
  }

 private:
  long double descend(std::size_t first, std::size_t left, const Triangle& information) {
    long double best = information.log_det();
    for (std::size_t i = first; i < problem_.blocks.size() && left > 0; ++i) {
      const std::uint32_t group = problem_.group_of(i);
      if (!problem_.is_free(i) || taken_[group] >= problem_.room()) continue;
      Triangle with_i = information;
      with_i.add(stored_block(problem_.blocks, i));
      taken_[group] += keeps_to_groups_ ? 1 : 0;
      best = std::max(best, descend(i + 1, left - 1, with_i));
      taken_[group] -= keeps_to_groups_ ? 1 : 0;
    }
    return best;
  }

  const Problem& problem_;
  bool keeps_to_groups_;
  std::map<std::uint32_t, std::size_t> taken_;
};

}  // namespace maxlogdet::test
