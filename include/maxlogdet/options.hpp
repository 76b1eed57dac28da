// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace maxlogdet {

/// How the k candidates are searched for.
enum class Strategy {
  greedy,             ///< evaluates all remaining candidates in every round; at least 1 - 1/e of the optimal gain
  lazy_greedy,        ///< greedy's answer, index for index, evaluating only candidates that could still win
  stochastic_greedy,  ///< evaluates a random sample per round (Algorithm 1); at least 1 - 1/e - epsilon in expectation
};

/// X(name) for each strategy, in their order. The names, the program, the Python module and the tests all use this list
/// (CONTRIBUTING.md).
#define MAXLOGDET_STRATEGIES(X) X(greedy) X(lazy_greedy) X(stochastic_greedy)

#define MAXLOGDET_ENUMERATOR(name) Strategy::name,
/// All strategies, to loop over.
constexpr Strategy strategies[] = {MAXLOGDET_STRATEGIES(MAXLOGDET_ENUMERATOR)};
#undef MAXLOGDET_ENUMERATOR

/// At most so many of a group. Arrays belong to the caller.
struct GroupOptions {
  const std::uint32_t* ids = nullptr;  ///< n: the group of each candidate, < count, also of invalid ones; nullptr: no
                                       ///< groups
  std::size_t count = 0;               ///< any number: groups without a candidate cost nothing
  std::size_t maximum = 1;             ///< how many to select of a group at most
};

/// stochastic_greedy only.
struct StochasticOptions {
  double epsilon = 0.1;    ///< in (0, 1): a round evaluates ceil(n / k ln(1 / epsilon)) candidates
  std::uint64_t seed = 0;  ///< same seed, same answer, on every machine
};

/// What to select and how: a budget alone suffices, as in select(blocks, 100). Arrays belong to the caller.
struct Options {
  std::size_t budget = 200;       ///< k, how many to select; all, if there are fewer
  const double* prior = nullptr;  ///< M0: 6 x 6 row-major, symmetric, in the units and the frame of the blocks. Where
                                  ///< it leaves a direction without information, the default is added. nullptr, the
                                  ///< default: a hundred-millionth of what a median block tells (docs/numerics.md)
  double time_limit = 0;  ///< s, after which the budget is filled at once. It cuts only rounds: what comes before them
                          ///< and a round under way are finished. 0: none
  Strategy strategy = Strategy::lazy_greedy;  ///< how to search
  int threads = 0;  ///< 1: only the calling one; 0: as many of the selector's executor as pay off; n: at most n, and at
                    ///< most 16; always 1 without an executor. The answer does not depend on it

  const unsigned char* required = nullptr;  ///< n: nonzero is selected in any case, first, and counts towards the
                                            ///< budget; must be valid (BlockStore::is_valid). Of a Selector alone:
                                            ///< GoodFeatures takes FeatureMatch::is_required instead
  double target_efficiency = 0;             ///< in (0, 1]: the D-efficiency against all candidates, (det M / det
                                            ///< M_all)^(1/6), that ends the selection before the budget is reached;
                                            ///< M_all has the prior and all that are valid. Required candidates come
                                            ///< first, then as many as the target needs: a prefix of the answer
                                            ///< without it. 0: none
  GroupOptions groups;                      ///< at most so many of a group
  StochasticOptions stochastic;             ///< of stochastic_greedy
  bool certificate = false;                 ///< whether to prove an upper bound of the maximum: Selection::upper_bound

  Options() = default;
  /// A budget; a negative one is 0.
  template <class Integer, class = typename std::enable_if<std::is_integral<Integer>::value &&
                                                           !std::is_same<Integer, bool>::value>::type>
  Options(Integer k) noexcept : budget(k > 0 ? static_cast<std::size_t>(k) : 0) {}  // NOLINT: as in select(100)
};

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(Strategy strategy) noexcept;

}  // namespace maxlogdet
