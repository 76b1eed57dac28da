// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

namespace maxlogdet::test {

/// What a selection says, kept beyond the next selection. Two are equal if all of it is, bit for bit, but for the
/// costs, which may differ between instruction sets.
struct Answer {
  Answer(const Selection& selection)  // NOLINT(google-explicit-constructor): compared as if it were one
      : reason(selection.reason()),
        indices(indices_of(selection)),
        searched(selection.searched),
        evaluations(selection.evaluations),
        float64_decisions(selection.float64_decisions) {
    for (std::size_t j = 0; j < selection.size; ++j) numbers.push_back(bits_of(selection.gains[j]));
    for (const double number : {selection.log_det, selection.upper_bound, selection.efficiency,
                                selection.translation_sigma, selection.rotation_sigma}) {
      numbers.push_back(bits_of(number));
    }
  }

  std::string reason;
  std::vector<std::uint32_t> indices;
  std::size_t searched, evaluations, float64_decisions;
  std::vector<std::uint64_t> numbers;  ///< the bits of gains, log det, upper bound and of what targets are about
};

/// By a selector of its own, of just enough capacity.
inline Answer answer_to(const BlockStore& blocks, const Options& options, Executor* executor = nullptr) {
  Selector selector(std::max(blocks.size(), options.budget), executor);
  return selector.select(blocks, options);
}

inline bool operator==(const Answer& a, const Answer& b) {
  return a.reason == b.reason && a.indices == b.indices && a.searched == b.searched && a.numbers == b.numbers;
}

inline void PrintTo(const Answer& answer, std::ostream* out) {
  *out << answer.reason << ", of " << answer.searched << " searched:";
  for (const std::uint32_t i : answer.indices) *out << ' ' << i;
  *out << "; bits";
  for (const std::uint64_t bits : answer.numbers) *out << ' ' << bits;
}

}  // namespace maxlogdet::test
