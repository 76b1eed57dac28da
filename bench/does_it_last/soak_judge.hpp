// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_last/soak_requests.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace maxlogdet::bench {

/// Decides whether an answer is well-formed. Allocates nothing: a soak counts every allocation.
class SoakJudge {
 public:
  /// What is wrong with the answer of a selector of this capacity; null if nothing is.
  const char* fault_of(const SoakRequest& request, std::size_t capacity, const Selection& selection) noexcept;

 private:
  const char* fault_of_indices(const BlockStore& store, const Options& options, const Selection& selection) noexcept;
  const char* fault_of_required(const BlockStore& store, const Options& options) const noexcept;

  std::array<std::uint64_t, SoakRequests::capacity> seen_{};      // the number of the last answer with each index
  std::array<std::uint32_t, SoakRequests::capacity> of_group_{};  // how many candidates of each group were selected
  std::uint64_t now_ = 0;                                         // number of the answer
};

}  // namespace maxlogdet::bench
