// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// How the k candidates are searched for.
enum class Strategy {
  greedy,             ///< every remaining candidate in every round; at least 1 - 1/e of the optimal gain
  lazy_greedy,        ///< greedy's answer, index for index, evaluating only candidates that could still win
  stochastic_greedy,  ///< a random sample a round (Algorithm 1); at least 1 - 1/e - epsilon in expectation
};

/// What to select and how. Every default is one that a tracker can ship.
struct Options {
  std::size_t budget = 100;                   ///< k, how many to select; 0: none; at most the selector's capacity
  Strategy strategy = Strategy::lazy_greedy;  ///< how to search
  double epsilon = 0.1;                       ///< stochastic_greedy only: 0 < epsilon < 1, s = ceil(n/k ln(1/epsilon))
  std::uint64_t seed = 0;                     ///< stochastic_greedy only: same seed, same answer, on every machine
  const double* prior = nullptr;  ///< M0: 6 x 6 row-major, symmetric positive definite, in the units and the
                                  ///< frame of the blocks; the caller owns it; nullptr: 1e-5 * I
  double time_limit = 0;          ///< s, looked at between rounds; 0: none
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Strategy strategy) noexcept;

}  // namespace maxlogdet
