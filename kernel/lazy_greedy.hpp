// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search.hpp"

#include <cstddef>

namespace maxlogdet {

/// What lazy greedy evaluates in a round. Until the selected rows span the state, gains are those against the prior and
/// say little about later ones; so three rounds at least evaluate every candidate. The round after that does so once
/// more, and orders them by what it finds.
class LazyRounds {
 public:
  explicit LazyRounds(Search& search) noexcept;

  /// Whether order() has to come before the next evaluate().
  bool order_is_due() const noexcept;
  void order() noexcept;

  /// Evaluates every candidate that may be the best.
  void evaluate() noexcept;

 private:
  std::size_t added() const noexcept { return search_.selected - start_; }

  Search& search_;
  std::size_t start_;  // selected before
  std::size_t first_rounds_;
  bool is_ordered_ = false;
};

}  // namespace maxlogdet
