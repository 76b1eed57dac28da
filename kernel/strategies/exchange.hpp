// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <cstddef>
#include <vector>

namespace maxlogdet {

/// Memory of exchange for up to `capacity` candidates.
struct ExchangeWorkspace {
  explicit ExchangeWorkspace(std::size_t capacity) : is_unselected(capacity), is_open(capacity), answer(capacity) {}
  std::vector<unsigned char> is_unselected;  ///< per candidate: whether it is free and not in the answer
  std::vector<unsigned char> is_open;        ///< per candidate: the same, and its group has room
  std::vector<Candidate> answer;             ///< with the swaps so far
};

/// At most `sweeps` sweeps over the answer. Each replaces every candidate that is not required by the best unselected
/// one if that increases log det (Fedorov 1972); log det never decreases. At the deadline the answer so far is kept.
Status exchange(Search& search, std::size_t sweeps, ExchangeWorkspace& own) noexcept;

}  // namespace maxlogdet
