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

/// The rounds of lazy greedy. Until the selected rows span the state, gains are those against the prior and predict
/// later ones poorly; so at least three rounds evaluate every candidate. The round after them does so once more, and
/// the candidates are ordered by its gains.
class LazyRounds {
 public:
  explicit LazyRounds(Search& search) noexcept;

  /// Whether order() must be called before the next open().
  bool order_is_due() const noexcept { return order_is_due_; }
  void order() noexcept;

  /// Starts a round, if none is open.
  void open() noexcept;
  /// Ends an open round; to be called before the information changes.
  void close() noexcept;
  bool is_open() const noexcept { return is_open_; }

 private:
  Search& search_;
  std::size_t min_selected_;  // number of candidates selected before the candidates are ordered
  bool is_open_ = false;
  bool order_is_due_ = false;
};

}  // namespace maxlogdet
