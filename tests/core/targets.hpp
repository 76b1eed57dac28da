// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <cstdint>
#include <vector>

// Targets by an oracle in long double that shares no formula with the library: log det and variances from the triangle
// of a QR decomposition of everything stacked.

namespace maxlogdet::test {

/// What an information has reached.
struct Reached {
  long double efficiency;
  long double translation_sigma, rotation_sigma;
};

/// Counts of selections.
struct Tally {
  int selections = 0;
  int cut = 0;   // before the budget
  int ties = 0;  // had a prefix within the tolerance of the target
};

/// Expects a third of them to be cut and at most `tie_share` to be ties, if there are many.
void expect_conclusive(const Tally& tally, double tie_share = 0.01);

/// An answer without targets, and what its prefixes have reached, the empty one included.
struct Prefixes {
  Prefixes(Selector& selector, const Problem& problem);

  std::vector<std::uint32_t> full;
  std::vector<Reached> reached;
};

/// Expects the answer to the problem to be the shortest prefix that meets its targets, and to report what it reached.
/// Within `tolerance`, relative, of a target either decision is right.
void expect_shortest(Selector& selector, const Problem& problem, const Prefixes& prefixes, long double tolerance,
                     Tally& tally);

/// The same for `repetitions` draws of one to three targets, which are near what some prefix reaches, or far from all.
void expect_drawn_targets_hold(Random& random, Problem problem, long double tolerance, Tally& tally, int repetitions);

}  // namespace maxlogdet::test
