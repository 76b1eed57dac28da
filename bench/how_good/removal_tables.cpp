// SPDX-License-Identifier: MIT
// Measures the removal of candidates: exchange sweeps, and backward elimination.
#include "bench/how_good/interleaved.hpp"
#include "bench/how_good/search_tables.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace maxlogdet::bench {
namespace {

constexpr std::size_t sweeps[] = {1, 2, 4};

// Lazy greedy without sweeps, then with each number of sweeps.
std::vector<Options> with_sweeps(std::size_t budget) {
  std::vector<Options> cases(1, options_of(Strategy::lazy_greedy, budget));
  for (const std::size_t count : sweeps) {
    cases.push_back(cases.front());
    cases.back().exchange.sweeps = count;
  }
  return cases;
}

// Means over the frames.
void write_exchange_row(std::size_t n, std::size_t k) {
  double gain[3] = {}, more[3] = {}, plain = 0, largest = 0;
  int improved = 0, problems = 0;
  for_every_problem({scene_families(), {n}}, [&](const Problem& problem) {
    const std::vector<Measured> found = measure(problem.store, with_sweeps(k));
    for (std::size_t i = 0; i < 3; ++i) {
      gain[i] += found[i + 1].log_det - found[0].log_det;
      more[i] += found[i + 1].microseconds - found[0].microseconds;
    }
    plain += found[0].microseconds;
    largest = std::max(largest, found[3].log_det - found[0].log_det);
    improved += found[3].log_det > found[0].log_det ? 1 : 0;
    ++problems;
  });
  std::printf("| %zu | %zu | %.4f | %.4f | %.4f | %.4f | %d of %d | %.1f | %.1f | %.1f | %.1f |\n", n, k,
              gain[0] / problems, gain[1] / problems, gain[2] / problems, largest, improved, problems, plain / problems,
              more[0] / problems, more[1] / problems, more[2] / problems);
}

// Mean times over the frames, their ratio, and the extremes of the ratios and differences over the frames.
void write_backward_row(std::size_t n, double share) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto k = static_cast<std::size_t>(std::lround(share * static_cast<double>(n)));
  const std::vector<Options> cases = {options_of(Strategy::lazy_greedy, k), options_of(Strategy::backward_greedy, k)};
  double lazy = 0, backward = 0, lowest_ratio = infinity, highest_ratio = 0, worst = infinity, best = -infinity;
  int problems = 0;
  for_every_problem({scene_families(), {n}}, [&](const Problem& problem) {
    const std::vector<Measured> found = measure(problem.store, cases);
    const double ratio = found[1].microseconds / found[0].microseconds;
    const double delta = found[1].log_det - found[0].log_det;
    lazy += found[0].microseconds;
    backward += found[1].microseconds;
    lowest_ratio = std::min(lowest_ratio, ratio);
    highest_ratio = std::max(highest_ratio, ratio);
    worst = std::min(worst, delta);
    best = std::max(best, delta);
    ++problems;
  });
  std::printf("| %zu | %g | %.0f | %.0f | %.2f | %.2f | %.2f | %+.0e | %+.0e |\n", n, share, lazy / problems,
              backward / problems, backward / lazy, lowest_ratio, highest_ratio, worst, best);
}

}  // namespace

void write_exchange_table() {
  begin_table("exchange", {"n", "k", "mean gain (nats), sweeps: 1", "2", "4", "largest", "improved", "µs",
                           "more µs, sweeps: 1", "2", "4"});
  for (const std::size_t n : {500U, 2000U}) {
    for (const std::size_t k : {6U, 8U, 12U, 20U, 40U, 60U, 100U}) write_exchange_row(n, k);
  }
}

void write_backward_table() {
  begin_table("backward", {"n", "k / n", "lazy_greedy µs", "backward_greedy µs", "ratio of these", "smallest ratio",
                           "largest", "Δ log det (nats), from", "to"});
  for (const std::size_t n : {200U, 500U, 2000U, 5000U}) {
    for (const double share : {0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95}) write_backward_row(n, share);
  }
}

}  // namespace maxlogdet::bench
