// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <limits>
#include <memory>

namespace maxlogdet {

/// Memory that a strategy has for itself. A strategy that needs any derives its own type from this, in its own file.
struct Workspace {
  Workspace() = default;
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  virtual ~Workspace() = default;
};

/// What a Selector has to know of a strategy. The file of each one defines its own: that of greedy is greedy_method.
struct Method {
  /// Selects until search.wants_more() says no: ok, or deadline_reached. `workspace`: as make_workspace made it.
  /// nullptr: `automatic` alone, which stands for another one.
  Status (*run)(Search& search, const Options& options, Workspace* workspace) noexcept;

  /// The first thing wrong with the options that matter to this strategy alone; ok if nothing is.
  Status (*check)(const Options& options) noexcept;

  /// Fewer candidates than this are not worth a second thread: from here on two are not slower, be their cores near
  /// each other or far apart (docs/threading.md).
  std::size_t crossover;

  /// The workspace for up to `capacity` candidates, allocated with the Selector; nullptr: the strategy needs none.
  std::unique_ptr<Workspace> (*make_workspace)(std::size_t capacity) = nullptr;
};

template <class Own>
std::unique_ptr<Workspace> make_workspace(std::size_t capacity) {
  return std::unique_ptr<Workspace>(new Own(capacity));
}

/// The crossover of a strategy whose rounds are too short for two threads.
constexpr std::size_t one_thread_only = std::numeric_limits<std::size_t>::max();

/// Checks of strategies that take any options, or any but groups and targets.
inline Status any_options(const Options& /*options*/) noexcept { return Status::ok; }
inline Status no_groups_or_targets(const Options& options) noexcept {
  if (options.groups != nullptr) return Status::unsupported_groups;
  return Target::is_asked(options) ? Status::unsupported_target : Status::ok;
}

#define MAXLOGDET_DECLARE(name) extern const Method name##_method;
MAXLOGDET_STRATEGIES(MAXLOGDET_DECLARE)
#undef MAXLOGDET_DECLARE

/// nullptr if the strategy is not one of the enumerators.
const Method* method_of(Strategy strategy) noexcept;

/// The workspaces of all strategies.
class Workspaces {
 public:
  explicit Workspaces(std::size_t capacity);
  Workspace* of(Strategy strategy) const noexcept { return workspaces_[static_cast<std::size_t>(strategy)].get(); }

 private:
  std::unique_ptr<Workspace> workspaces_[sizeof strategies / sizeof *strategies];
};

/// The strategy that `automatic` stands for; by the problem alone, so that the answer does not depend on threads.
Strategy chosen_for(const Search& search) noexcept;

}  // namespace maxlogdet
