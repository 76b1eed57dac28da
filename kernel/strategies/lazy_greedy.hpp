// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <cstddef>

namespace maxlogdet {

/// The answer of greedy with fewer evaluations: gains only decrease (submodularity), so a candidate whose last known
/// gain is below the best of this round need not be evaluated again (Minoux 1978), here by tiles.
Status lazy_greedy(Search& search) noexcept;

/// The same among the candidates that the screening holds, in the order of the store or as listed.
Status search_lazily(Search& search) noexcept;

/// The evaluations of lazy greedy's rounds. Until the selected rows span the state, gains are those against the prior
/// and predict later ones poorly; so at least three rounds evaluate every candidate. The round after them does so once
/// more, and the candidates are ordered by its gains.
class LazyRounds {
 public:
  explicit LazyRounds(Search& search) noexcept;

  /// Whether order() must be called before the next evaluate().
  bool order_is_due() const noexcept { return order_is_due_; }
  void order() noexcept;

  /// Evaluates every candidate that may be one of the k best. Called again in the same round, after withdrawals, it
  /// evaluates those that may be so now.
  void evaluate(std::size_t k = 1) noexcept;

  /// Keeps stale bounds for later rounds; to be called before the information and the tiles change.
  void finish() noexcept;

  /// Whether this is between evaluate() and finish().
  bool is_open() const noexcept { return is_open_; }

 private:
  Search& search_;
  std::size_t start_;  // number of candidates selected before
  std::size_t first_rounds_;
  bool is_open_ = false;  // within a round
  bool order_is_due_ = false;
  bool is_ordered_ = false;
};

}  // namespace maxlogdet
