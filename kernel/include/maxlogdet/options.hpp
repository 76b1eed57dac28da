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
  relaxed,            ///< convex relaxation (D-optimal design), rounded and polished; as good as greedy (measured, no
                      ///< guarantee), and faster from tens of thousands of candidates on (docs/performance.md)
  backward_greedy,    ///< all but the n - k of least loss, removed one by one: for k > n / 2
  automatic,  ///< by the n candidates that may be selected: backward_greedy if 3 k >= 2 n, relaxed if n >= 50000
              ///< and k >= 60, else, with groups and with targets, lazy_greedy; Selection::strategy tells which
};

/// X(name) for each of them, in their order. Whatever goes by a list of strategies goes by this one: the selector, the
/// names, the program, the Python module and the tests (CONTRIBUTING.md).
#define MAXLOGDET_STRATEGIES(X) X(greedy) X(lazy_greedy) X(stochastic_greedy) X(relaxed) X(backward_greedy) X(automatic)

#define MAXLOGDET_ENUMERATOR(name) Strategy::name,
/// The same to loop over.
constexpr Strategy strategies[] = {MAXLOGDET_STRATEGIES(MAXLOGDET_ENUMERATOR)};
#undef MAXLOGDET_ENUMERATOR

/// What to select and how. Every default is one that a tracker can ship. Arrays belong to the caller.
struct Options {
  std::size_t budget = 100;                   ///< k, how many to select; 0: none; at most the selector's capacity
  Strategy strategy = Strategy::lazy_greedy;  ///< how to search
  double epsilon = 0.1;                       ///< stochastic_greedy only: 0 < epsilon < 1, s = ceil(n/k ln(1/epsilon))
  std::uint64_t seed = 0;                     ///< stochastic_greedy only: same seed, same answer, on every machine
  const double* prior = nullptr;  ///< M0: 6 x 6 row-major, symmetric positive definite, in the units and the
                                  ///< frame of the blocks; nullptr: 1e-5 * I
  double time_limit = 0;          ///< s, looked at between rounds, so that it is exceeded by one at most, and by the
                                  ///< certificate's look at all candidates; backward_greedy begins with all of them in.
                                  ///< What there is by then may be little, or nothing. 0: none
  int threads = 0;  ///< 1: the calling one alone; 0: as many of the selector's executor as pay off; n: at most n, and
                    ///< at most 16; without an executor always one. The answer does not depend on it

  bool certify = false;  ///< fills Selection::upper_bound
  std::size_t certificate_passes =
      0;  ///< most Frank-Wolfe passes that tighten it, some microseconds each (docs/performance.md): as long as they
          ///< gain anything, and the time limit leaves time for them
  std::size_t exchange_sweeps = 0;  ///< after the search, at most so many sweeps that swap a selected candidate for a
                                    ///< better one; pays for budgets of 20 or less (docs/performance.md)

  double target_efficiency = 0;  ///< in (0, 1]: stop when the D-efficiency of the selected against all candidates,
                                 ///< (det M / det M_all)^(1/6), is that much. M_all: the prior and all candidates that
                                 ///< are valid and not excluded, whatever groups allow. 0: none
  double target_translation_sigma = 0;  ///< m: stop when the expected deviation of the translation, the root of the
                                        ///< trace of its 3 x 3 block of M^-1, is at most that. 0: none
  double target_rotation_sigma = 0;     ///< rad: the same of the rotation. 0: none. Of several targets all have to be
                                        ///< met; what is required is in before, and then as many as they take, at most
                                        ///< the budget: the first of those that there are without targets.
                                        ///< With greedy, lazy_greedy and stochastic_greedy, without exchange_sweeps;
                                        ///< automatic is lazy_greedy then

  const unsigned char* required = nullptr;  ///< n: nonzero is selected in any case, first, and counts as budget; has
                                            ///< to be valid (BlockStore::is_valid), else nothing is selected
  const unsigned char* excluded = nullptr;  ///< n: nonzero is not selected
  const std::uint32_t* groups = nullptr;    ///< n: group of each candidate, < group_count, of invalid and excluded
                                            ///< ones too; nullptr: no groups, whatever the three below
  std::size_t group_count = 0;              ///< any number: groups without a candidate cost nothing
  std::size_t max_per_group = 1;            ///< most to select of a group
  const std::uint32_t* group_maxima = nullptr;  ///< group_count: most to select of each; nullptr: max_per_group
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Strategy strategy) noexcept;

}  // namespace maxlogdet
