// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/top_traces.hpp"
#include "kernel/search/search.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Memory of fill among up to `capacity` candidates.
struct FillMemory {
  explicit FillMemory(std::size_t capacity)
      : is_open(capacity), shortlist(capacity), spread(capacity), traces(capacity), order(capacity) {}
  std::vector<unsigned char> is_open;  ///< per candidate: 1 if it may still be selected
  std::vector<Candidate> shortlist;    ///< candidates to add, in ascending order
  std::vector<Candidate> spread;       ///< open ones at equal distances
  std::vector<double> traces;          ///< of the shortlist
  std::vector<std::uint32_t> order;    ///< positions in the shortlist, by trace
};

/// After a deadline: adds candidates until search.wants_more() is false, about as fast as they can be looked at once
/// and added. They are those of most information, at the information to be expected of a whole answer: at that of the
/// answer so far, nearly identical ones would be taken together. What it adds depends only on the answer so far, not on
/// the machine.
void fill(Search& search, FillMemory& own, TraceMemory& traces) noexcept;

}  // namespace maxlogdet
