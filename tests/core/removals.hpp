// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

// Helpers of the tests of backward greedy.

namespace maxlogdet::test {

/// Options of backward greedy that keep `budget` candidates.
inline Options keeping(std::size_t budget) { return with_budget(budget, Strategy::backward_greedy); }

/// The largest loss, nats, that backward greedy's removals down to `min_budget`, at least what is required, exceed the
/// smallest loss there was by in their round; recomputed in long double.
long double loss_given_away(Problem problem, std::size_t min_budget);

/// Expects the same removals whether stale bounds of losses are used or all losses are computed in every round.
void expect_the_same_with_stale_bounds(const BlockStore& blocks, const Options& options);

}  // namespace maxlogdet::test
