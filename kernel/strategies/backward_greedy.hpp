// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/screening/losses.hpp"
#include "kernel/search/search.hpp"
#include "kernel/strategies/method.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

struct BackwardWorkspace : Workspace {
  explicit BackwardWorkspace(std::size_t capacity)
      : is_left(capacity), is_counted(capacity), answer(capacity), losses(capacity) {}
  std::vector<unsigned char> is_left;     ///< per candidate: whether it has not been removed
  std::vector<unsigned char> is_counted;  ///< per candidate: whether its information is summed
  std::vector<Candidate> answer;          ///< what is left
  LossesMemory losses;
};

/// Backward elimination: starts from all candidates and removes the one of minimum loss, -log det(I - Y Y^T), until the
/// budget remains; ties go to the highest index. The answer is listed by index. `lazily`: without evaluating candidates
/// that cannot have the minimum loss; the same answer. At the deadline it leaves all to fill().
Status backward_greedy(Search& search, BackwardWorkspace& own, bool lazily = true) noexcept;

}  // namespace maxlogdet
