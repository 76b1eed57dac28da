// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {

/// Options with the arrays that they point to, each of which may be empty: then it is not given.
struct Request {
  std::vector<unsigned char> required;
  std::vector<std::uint32_t> groups;
  std::vector<double> prior;
  Options plain;  ///< all but the arrays

  Options options() const;
  Options options(Strategy strategy) const;

  void set_prior(const Matrix6& information);

  bool is_required(std::size_t i) const { return !required.empty() && required[i] != 0; }
  std::size_t required_count() const;
  /// The group of candidate i, and how many of a group may be selected; all are in one group if there are no groups.
  std::uint32_t group_of(std::size_t i) const { return groups.empty() ? 0 : groups[i]; }
  std::size_t room() const;
};

/// Candidates, and a request for some of them.
struct Problem : Request {
  BlockStore blocks;

  /// The capacity that a selector needs for it.
  std::size_t capacity() const;
  /// The prior that it starts from.
  Matrix6 information() const;
  /// Whether a strategy may choose it: valid, not required.
  bool is_free(std::size_t i) const { return blocks.is_valid(i) && !is_required(i); }
};

/// Without any constraint.
Problem problem_of(BlockStore blocks, std::size_t budget);

/// Gives it any subset of the constraints, such that there is an answer, and any budget.
void constrain(Random& random, Problem& problem, bool has_groups);
void constrain(Random& random, Problem& problem);

/// Any candidates, prior and constraints.
Problem any_problem(Random& random, std::size_t n);

/// A flag for each of n candidates, set for a share of them.
std::vector<unsigned char> random_flags(Random& random, std::size_t n, double share);

/// Expects what holds of any answer, whatever the strategy: distinct valid candidates, the required ones among them; as
/// many as budget and groups allow, and no more; a status that fits; gains and log det as computed
/// in long double, to `tolerance` nats; and no upper bound below log det.
void expect_sound(const Problem& problem, const Selection& selection, double tolerance = 1e-7);

}  // namespace maxlogdet::test
