// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/oracle.hpp"

#include <cstdint>
#include <vector>

// Helpers of the tests of backward greedy.

namespace maxlogdet::test {

/// Options of backward greedy that keep `budget` candidates.
inline Options keeping(std::size_t budget) { return with_budget(budget, Strategy::backward_greedy); }

/// The candidates in the order of their removal, as answers to ever smaller budgets down to `min_budget` tell.
std::vector<std::uint32_t> order_of_removal(const BlockStore& blocks, Options options, std::size_t min_budget = 0);

/// The maximum over the rounds by which a removal's loss exceeds the minimum loss there was, nats; recomputed by QR in
/// long double.
long double loss_given_away(const BlockStore& blocks, const std::vector<std::uint32_t>& order,
                            const Matrix6& prior = default_information());

/// Expects the same answer whether stale bounds of losses are used or all losses are computed in every round.
void expect_the_same_with_stale_bounds(const BlockStore& blocks, const Options& options);

}  // namespace maxlogdet::test
