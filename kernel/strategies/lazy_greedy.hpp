// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <cstddef>

namespace maxlogdet {

/// The answer of greedy for less work: gains only decrease (submodularity), so a candidate whose last known gain is
/// below the best found in this round need not be evaluated again (Minoux 1978), here by tiles of candidates.
Status lazy_greedy(Search& search) noexcept;

/// The same among what the screening holds, in the order of the store or as listed.
Status search_lazily(Search& search) noexcept;

/// What lazy greedy evaluates in a round. Until the selected rows span the state, gains are those against the prior and
/// say little about later ones; so three rounds at least evaluate every candidate. The round after that does so once
/// more, and orders them by what it finds.
class LazyRounds {
 public:
  explicit LazyRounds(Search& search) noexcept;

  /// Whether order() has to come before the next evaluate().
  bool order_is_due() const noexcept { return order_is_due_; }
  void order() noexcept;

  /// Evaluates every candidate that may be one of the `wanted` best. Again in the same round, after some were
  /// withdrawn, it evaluates those that may be now.
  void evaluate(std::size_t wanted = 1) noexcept;

  /// Remembers what this tells about later rounds; before the information changes, and tiles with it.
  void finish() noexcept;

  /// Between evaluate() and finish().
  bool is_open() const noexcept { return is_open_; }

 private:
  Search& search_;
  std::size_t start_;  // selected before
  std::size_t first_rounds_;
  bool is_open_ = false;  // within a round
  bool order_is_due_ = false;
  bool is_ordered_ = false;
};

}  // namespace maxlogdet
