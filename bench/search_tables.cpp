// SPDX-License-Identifier: MIT
// Where the searches beyond lazy greedy pay: tables in Markdown on stdout, for docs/performance.md.
// Usage: maxlogdet_search_tables exchange|backward; bench/run_search_tables calls it.
#include "bench/problem.hpp"
#include "sim/scene.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

struct Found {
  double microseconds = std::numeric_limits<double>::infinity();  // the fastest of all runs
  double log_det = 0;
};

// The cases by turns, so that what slows the machine down for a while slows all of them down.
std::vector<Found> measure(const BlockStore& blocks, const std::vector<Options>& cases) {
  using Clock = std::chrono::steady_clock;
  constexpr double seconds = 0.06;
  constexpr int fewest_turns = 5;
  Selector selector(blocks.size());
  std::vector<Found> found(cases.size());
  const auto since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  const auto first = Clock::now();
  for (int turn = 0; turn < fewest_turns || since(first) < seconds; ++turn) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const auto start = Clock::now();
      const Selection selection = selector.select(blocks, cases[i]);
      found[i].microseconds = std::min(found[i].microseconds, 1e6 * since(start));
      found[i].log_det = selection.log_det;
    }
  }
  return found;
}

Options with(Strategy strategy, std::size_t budget, std::size_t sweeps = 0) {
  Options options;
  options.strategy = strategy;
  options.budget = budget;
  options.exchange_sweeps = sweeps;
  return options;
}

constexpr Blocks kinds[] = {Blocks::two_rows, Blocks::two_rows_measurement, Blocks::three_rows,
                            Blocks::three_rows_measurement};

// Calls body(store) for synthetic frames of n candidates, of every scene and kind of block.
template <class Body>
void for_every_frame(std::size_t n, const Body& body) {
  for (const sim::Scene scene : sim::scenes) {
    for (const Blocks blocks : kinds) body(stores_of(to_string(scene), n, blocks).front());
  }
}

void exchange_table() {
  std::printf(
      "| n | k | mean gain (nats), sweeps: 1 | 2 | 4 | largest | improved | µs | more µs, sweeps: 1 | 2 | 4 |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|\n");
  const std::size_t sweeps[] = {1, 2, 4};
  for (const std::size_t n : {500U, 2000U}) {
    for (const std::size_t k : {6U, 8U, 12U, 20U, 40U, 60U, 100U}) {
      double gain[3] = {}, more[3] = {}, plain = 0, largest = 0;
      int improved = 0, stores = 0;
      for_every_frame(n, [&](const BlockStore& store) {
        std::vector<Options> cases = {with(Strategy::lazy_greedy, k)};
        for (const std::size_t count : sweeps) cases.push_back(with(Strategy::lazy_greedy, k, count));
        const std::vector<Found> found = measure(store, cases);
        for (std::size_t i = 0; i < 3; ++i) {
          gain[i] += found[i + 1].log_det - found[0].log_det;
          more[i] += found[i + 1].microseconds - found[0].microseconds;
        }
        plain += found[0].microseconds;
        largest = std::max(largest, found[3].log_det - found[0].log_det);
        improved += found[3].log_det > found[0].log_det ? 1 : 0;
        ++stores;
      });
      std::printf("| %zu | %zu | %.4f | %.4f | %.4f | %.4f | %d of %d | %.1f | %.1f | %.1f | %.1f |\n", n, k,
                  gain[0] / stores, gain[1] / stores, gain[2] / stores, largest, improved, stores, plain / stores,
                  more[0] / stores, more[1] / stores, more[2] / stores);
      std::fflush(stdout);
    }
  }
}

// Means over all frames and kinds of blocks; ratios of single ones.
void backward_table() {
  std::printf(
      "| n | k / n | lazy_greedy µs | backward_greedy µs | ratio of these | smallest ratio | largest | Δ log det "
      "(nats), "
      "from | to |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|\n");
  for (const std::size_t n : {200U, 500U, 2000U, 5000U}) {
    for (const double share : {0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95}) {
      const auto k = static_cast<std::size_t>(std::lround(share * static_cast<double>(n)));
      double lazy = 0, backward = 0, smallest = 1e9, largest = 0, worst = 1e9, best = -1e9;
      int stores = 0;
      for_every_frame(n, [&](const BlockStore& store) {
        const auto found = measure(store, {with(Strategy::lazy_greedy, k), with(Strategy::backward_greedy, k)});
        const double ratio = found[1].microseconds / found[0].microseconds;
        const double delta = found[1].log_det - found[0].log_det;
        lazy += found[0].microseconds;
        backward += found[1].microseconds;
        smallest = std::min(smallest, ratio);
        largest = std::max(largest, ratio);
        worst = std::min(worst, delta);
        best = std::max(best, delta);
        ++stores;
      });
      std::printf("| %zu | %g | %.0f | %.0f | %.2f | %.2f | %.2f | %+.0e | %+.0e |\n", n, share, lazy / stores,
                  backward / stores, backward / lazy, smallest, largest, worst, best);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::bench

int main(int argc, char** argv) {
  const std::string table = argc == 2 ? argv[1] : "";
  if (table == "exchange") {
    maxlogdet::bench::exchange_table();
  } else if (table == "backward") {
    maxlogdet::bench::backward_table();
  } else {
    std::fputs("usage: maxlogdet_search_tables exchange|backward\n", stderr);
    return 2;
  }
  return 0;
}
