// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/top_traces.hpp"
#include "kernel/screening/losses.hpp"

#include <cstddef>

namespace maxlogdet {

/// Memory of the strategies, of exchange() and of fill(), for up to `capacity` candidates. Each uses it alone, and
/// leaves nothing in it to the next one.
struct StrategyMemory {
  explicit StrategyMemory(std::size_t capacity)
      : remains(capacity),
        is_counted(capacity),
        shortlist(capacity),
        united(capacity),
        answer(capacity),
        traces(capacity),
        losses(capacity) {}

  ArrayOf<Candidate, unsigned char> remains;     ///< whether it may still be selected, or has not been removed
  ArrayOf<Candidate, unsigned char> is_counted;  ///< whether it is one of those in question
  AlignedArray<Candidate> shortlist;             ///< candidates to choose from
  AlignedArray<Candidate> united;                ///< others for the shortlist, or its union with them
  AlignedArray<Candidate> answer;                ///< what becomes the answer of the search
  TraceMemory traces;
  LossesMemory losses;
};

}  // namespace maxlogdet
