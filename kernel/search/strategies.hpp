// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/search/search.hpp"

#include <maxlogdet/options.hpp>
#include <maxlogdet/status.hpp>

namespace maxlogdet {

// The three loops of the paper. Each selects until search.wants_more() is false, and returns ok, or deadline_reached
// where the time limit has passed before.

/// k rounds, each selecting the remaining candidate of maximum gain (Nemhauser et al. 1978).
Status greedy(Search& search) noexcept;

/// The answer of greedy with fewer evaluations: gains only decrease (submodularity), so a candidate whose last known
/// gain is below the best of this round need not be evaluated again (Minoux 1978), here by tiles.
Status lazy_greedy(Search& search) noexcept;

/// Algorithm 1 of the paper: in each round the best of a random sample of s = ceil(n / k ln(1 / epsilon)).
Status stochastic_greedy(Search& search, const StochasticOptions& options) noexcept;

/// The same with small samples and without a deadline: adds what a time limit has left missing.
void fill(Search& search) noexcept;

}  // namespace maxlogdet
