// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::fuzz {

/// Whether any target is given, valid or not.
bool has_target(const Options& options);

/// The same options without targets.
Options without_target(Options options);

/// What options require of a selection, read as plainly as possible.
class Rules {
 public:
  Rules(const BlockStore& candidates, const Options& options) : candidates_(candidates), options_(options) {}

  bool is_required(std::size_t i) const { return options_.required != nullptr && options_.required[i] != 0; }
  bool has_groups() const { return options_.groups.ids != nullptr && candidates_.size() > 0; }

  /// How many of these are in a group.
  std::size_t count_in(std::size_t group, const std::vector<std::uint32_t>& chosen) const;

  /// Whether one more could be added to those chosen, regardless of the budget.
  bool may_add(std::size_t i, const std::vector<std::uint32_t>& chosen) const;

  std::vector<std::uint32_t> required() const;

  /// Everything that is wrong with the request, for a selector of this capacity; of several errors any may be named. If
  /// the list is empty, there has to be an answer. `prior_is_unclear`: rounding decides whether the prior is valid.
  std::vector<Error> errors(std::size_t capacity, bool& prior_is_unclear) const;

 private:
  bool targets_are_valid() const;
  bool groups_exist() const;
  bool is_feasible() const;

  const BlockStore& candidates_;
  const Options& options_;
};

/// Fails unless this is an error that Rules expects, or none where it expects none; true if it is an error.
bool is_expected_error(const Rules& rules, std::size_t capacity, Error error);

}  // namespace maxlogdet::fuzz
