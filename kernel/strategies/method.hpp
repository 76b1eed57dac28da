// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"
#include "kernel/search/strategy_memory.hpp"

#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <limits>

namespace maxlogdet {

/// A strategy, as a Selector sees it. The file of each strategy defines its own: greedy_method for greedy.
struct Method {
  /// Selects until search.wants_more() is false. Returns ok or deadline_reached. nullptr only for `automatic`, which
  /// stands for another strategy.
  Status (*run)(Search& search, const Options& options, StrategyMemory& memory) noexcept;

  /// Returns the first error of the options that only this strategy uses, or none.
  Error (*check)(const Options& options) noexcept;

  /// The minimum number of candidates for a second thread: from here on two are not slower, whether their cores share a
  /// cache or not (docs/threading.md).
  std::size_t crossover;
};

/// The crossover of a strategy whose rounds are too short for two threads.
constexpr std::size_t one_thread_only = std::numeric_limits<std::size_t>::max();

/// Checks of strategies that accept any options, or any but groups and targets.
inline Error any_options(const Options& /*options*/) noexcept { return Error::none; }
inline Error no_groups_or_targets(const Options& options) noexcept {
  if (options.groups.ids != nullptr) return Error::unsupported_groups;
  return Target::is_asked(options) ? Error::unsupported_target : Error::none;
}

#define MAXLOGDET_DECLARE(name) extern const Method name##_method;
MAXLOGDET_STRATEGIES(MAXLOGDET_DECLARE)
#undef MAXLOGDET_DECLARE

/// Returns nullptr if the strategy is not one of the enumerators.
const Method* method_of(Strategy strategy) noexcept;

/// The strategy that `automatic` stands for; depends on the problem only, so that threads do not change the answer.
Strategy chosen_for(Search& search, const Options& options) noexcept;

}  // namespace maxlogdet
