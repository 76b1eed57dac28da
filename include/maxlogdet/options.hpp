// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// How the k candidates are searched for.
enum class Strategy {
  greedy,             ///< evaluates all remaining candidates in every round; at least 1 - 1/e of the optimal gain
  lazy_greedy,        ///< greedy's answer, index for index, evaluating only candidates that could still win
  stochastic_greedy,  ///< evaluates a random sample per round (Algorithm 1); at least 1 - 1/e - epsilon in expectation
  relaxed,  ///< convex relaxation (D-optimal design), rounded and polished; as good as greedy (measured, no guarantee),
            ///< and faster from tens of thousands of candidates on (docs/performance.md)
  backward_greedy,  ///< removes n - k candidates one by one, always that of minimum loss: pays from k of about 2 n / 3
                    ///< on
  automatic,  ///< depends on the n candidates that may be selected: backward_greedy if 3 k >= 2 n, relaxed if n >=
              ///< 50000 and k >= 60, else, and with groups or targets, lazy_greedy; Selection::strategy tells which
};

/// X(name) for each strategy, in their order. The selector, the names, the program, the Python module and the tests all
/// use this list (CONTRIBUTING.md).
#define MAXLOGDET_STRATEGIES(X) X(greedy) X(lazy_greedy) X(stochastic_greedy) X(relaxed) X(backward_greedy) X(automatic)

#define MAXLOGDET_ENUMERATOR(name) Strategy::name,
/// All strategies, to loop over.
constexpr Strategy strategies[] = {MAXLOGDET_STRATEGIES(MAXLOGDET_ENUMERATOR)};
#undef MAXLOGDET_ENUMERATOR

/// What to select and how. Every default suits a tracker in production. Arrays belong to the caller.
struct Options {
  std::size_t budget = 200;                   ///< k, how many to select; 0: none; at most the selector's capacity
  Strategy strategy = Strategy::lazy_greedy;  ///< how to search
  double epsilon = 0.1;                       ///< stochastic_greedy only: 0 < epsilon < 1, s = ceil(n/k ln(1/epsilon))
  std::uint64_t seed = 0;                     ///< stochastic_greedy only: same seed, same answer, on every machine
  const double* prior = nullptr;  ///< M0: 6 x 6 row-major, symmetric positive definite, in the units and the frame of
                                  ///< the blocks; nullptr: 1e-5 * I
  double time_limit = 0;  ///< s, checked between rounds: exceeded by at most one of them, and by the certificate's
                          ///< pass over all candidates; backward_greedy starts with a pass over all. The answer so far
                          ///< is returned, perhaps empty. 0: none
  int threads = 0;  ///< 1: only the calling one; 0: as many of the selector's executor as pay off; n: at most n, and at
                    ///< most 16; always 1 without an executor. The answer does not depend on it

  bool certify = false;                ///< fills Selection::upper_bound
  std::size_t certificate_passes = 0;  ///< maximum number of Frank-Wolfe passes that tighten it, some microseconds each
                                       ///< (docs/performance.md), while they gain anything and the time limit allows
  std::size_t exchange_sweeps = 0;  ///< maximum number of sweeps, after the search, that swap a selected candidate for
                                    ///< a better one; pays for budgets of 20 or less (docs/performance.md)

  double target_efficiency = 0;  ///< in (0, 1]: stop when the D-efficiency of the selected against all candidates, (det
                                 ///< M / det M_all)^(1/6), is that high. M_all: the prior and all candidates that are
                                 ///< valid and not excluded, regardless of groups. 0: none
  double target_translation_sigma = 0;  ///< m: stop when the expected standard deviation of the translation, the root
                                        ///< of the trace of its 3 x 3 block of M^-1, is at most that. 0: none
  double target_rotation_sigma = 0;     ///< rad: the same for the rotation. 0: none. If several targets are given, all
                                     ///< must be met. Required candidates come first, then as many as the targets need,
                                     ///< at most the budget: a prefix of the answer without targets. For strategies
                                     ///< that support them, without exchange_sweeps; automatic then means lazy_greedy

  const unsigned char* required = nullptr;  ///< n: nonzero is selected in any case, first, and counts towards the
                                            ///< budget; must be valid (BlockStore::is_valid), or nothing is selected
  const unsigned char* excluded = nullptr;  ///< n: nonzero is not selected
  const std::uint32_t* groups = nullptr;    ///< n: group of each candidate, < group_count, also of invalid and excluded
                                            ///< ones; nullptr: no groups, whatever the three below
  std::size_t group_count = 0;              ///< any number: groups without a candidate cost nothing
  std::size_t max_per_group = 1;            ///< maximum to select of a group
  const std::uint32_t* group_maxima = nullptr;  ///< group_count: maximum to select of each; nullptr: max_per_group
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Strategy strategy) noexcept;

/// Whether the strategy takes Options::groups, and targets: it then selects one candidate after the other. False for
/// any other value.
bool supports_groups_and_targets(Strategy strategy) noexcept;

}  // namespace maxlogdet
