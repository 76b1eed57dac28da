// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/epsilon_experiment.hpp"
#include "bench/world/table.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// epsilon.csv: a row for each outcome, with the number of its run: `runs` has one entry for each size of each run.
Table epsilon_table(const EpsilonOptions& options, const std::vector<std::vector<EpsilonOutcome>>& runs);

/// By epsilon, over the whole grid: the minimum of f / f(greedy) beside the guarantee 1 - 1/e - epsilon;
/// mean gap, share of differing features, and savings of gains and time against greedy and lazy greedy.
Table guarantee_table(const EpsilonOptions& options, const std::vector<std::vector<EpsilonOutcome>>& runs);

/// The same at one n and k. The paper's "43 x" is k / ln(1/epsilon) at k = 100, epsilon = 0.1.
Table speedup_table(const EpsilonOptions& options, const std::vector<std::vector<EpsilonOutcome>>& runs, std::size_t n,
                    std::size_t k);

}  // namespace maxlogdet::sim
