// SPDX-License-Identifier: MIT
// Measures the cost of a target: the same selections without one, and with targets that no budget here reaches.
#include "bench/how_good/interleaved.hpp"
#include "bench/how_good/search_tables.hpp"

#include <algorithm>
#include <cstdio>

namespace maxlogdet::bench {
namespace {

// Without a target; with both deviations; with the efficiency, which needs the information of all candidates.
std::vector<Options> with_targets(Strategy strategy, std::size_t budget) {
  std::vector<Options> cases(3, options_of(strategy, budget));
  cases[1].target.translation_sigma = 1e9;  // met, so that the other one is checked, too
  cases[1].target.rotation_sigma = 1e-12;
  cases[2].target.efficiency = 1;
  return cases;
}

// Means over the frames, and the extremes for the efficiency.
void write_row(std::size_t n, std::size_t k, Strategy strategy) {
  double plain = 0, more_of_deviations = 0, more_of_efficiency = 0, lowest = 1e9, highest = 0;
  int problems = 0;
  for_every_problem({scene_families(), {n}}, [&](const Problem& problem) {
    const std::vector<Measured> found = measure(problem.store, with_targets(strategy, k));
    const double more = found[2].microseconds - found[0].microseconds;
    plain += found[0].microseconds;
    more_of_deviations += found[1].microseconds - found[0].microseconds;
    more_of_efficiency += more;
    lowest = std::min(lowest, more);
    highest = std::max(highest, more);
    ++problems;
  });
  std::printf("| %s | %zu | %zu | %.1f | %.1f | %.1f | %.1f | %.1f |\n", to_string(strategy), n, k, plain / problems,
              more_of_deviations / problems, more_of_efficiency / problems, lowest, highest);
}

}  // namespace

void write_target_table() {
  begin_table("stopping", {"strategy", "n", "k", "µs without", "more µs, both deviations", "more µs, efficiency",
                           "minimum of a frame", "maximum"});
  for (const Strategy strategy : {Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
    for (const std::size_t n : {400U, 2000U}) write_row(n, 100, strategy);
  }
}

}  // namespace maxlogdet::bench
