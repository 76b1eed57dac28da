// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/table.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// Section IV of the paper: cost and benefit of the decay factor epsilon of stochastic greedy (Algorithm 1), over the
/// paper's grid of n, k and epsilon, on EuRoC-like frames.
struct EpsilonOptions {
  std::vector<std::size_t> sizes = {100, 200, 500, 1000, 2000, 3000};     ///< n
  std::vector<double> shares = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8};  ///< k / n
  std::vector<double> epsilons = {1,    0.5,   0.2,  0.1,
                                  0.05, 0.025, 0.01, 0.005};  ///< 1: one random candidate in each round
  std::uint64_t seed = 0;
};

/// One frame, one k, one epsilon.
struct EpsilonOutcome {
  std::size_t n = 0;
  std::size_t k = 0;
  double epsilon = 0;
  double us = 0;               ///< wall time of a selection, the median of 3
  double us_greedy = 0;        ///< of greedy: every candidate in every round
  double us_lazy = 0;          ///< of lazy greedy: greedy's answer
  double gains = 0;            ///< s k: gains of the algorithm (a round has at most the remaining candidates)
  double gains_greedy = 0;     ///< sum of n - i
  double share_of_greedy = 0;  ///< f / f(greedy), f = log det M - log det M0
};

/// Runs a frame of n matches with every share and epsilon, in that order: deterministic in options and run, except
/// times.
std::vector<EpsilonOutcome> run_epsilon(const EpsilonOptions& options, std::size_t n, std::uint64_t run);

/// By epsilon, over the whole grid and at n = 1000, k = 100: the minimum of f / f(greedy) beside the guarantee 1 - 1/e
/// - epsilon, and mean savings of gains and time. The paper's "43 x" is k / ln(1/epsilon) at k = 100, epsilon = 0.1.
Table epsilon_table(const EpsilonOptions& options, const std::vector<EpsilonOutcome>& outcomes);

}  // namespace maxlogdet::sim
