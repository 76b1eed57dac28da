// SPDX-License-Identifier: MIT
#include "bench/how_good/interleaved.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace maxlogdet::bench {

std::vector<Measured> measure(const BlockStore& store, const std::vector<Options>& cases) {
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  // Some hundred turns of a typical case, and all tables in about a minute. Cases of a second per call get three turns.
  constexpr Seconds min_time(0.03);
  constexpr int min_turns = 3;
  Selector selector(store.size());
  std::vector<Measured> results(cases.size());
  const auto begin = Clock::now();
  for (int turn = 0; turn < min_turns || Clock::now() - begin < min_time; ++turn) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      Selection selection{};
      const double microseconds = microseconds_of([&] { selection = selector.select(store, cases[i]); });
      results[i].microseconds = std::min(results[i].microseconds, microseconds);
      results[i].log_det = selection.log_det;
      results[i].gap = selection.upper_bound - selection.log_det;
    }
  }
  return results;
}

Options options_of(Strategy strategy, std::size_t budget) {
  Options options;
  options.strategy = strategy;
  options.budget = budget;
  return options;
}

void begin_table(const char* name, const std::vector<const char*>& columns) {
  std::fprintf(stderr, "measuring for the table %s\n", name);
  std::printf("table %s\n|", name);
  for (const char* const column : columns) std::printf(" %s |", column);
  std::printf("\n|");
  for (std::size_t i = 0; i < columns.size(); ++i) std::printf("---|");
  std::printf("\n");
}

}  // namespace maxlogdet::bench
