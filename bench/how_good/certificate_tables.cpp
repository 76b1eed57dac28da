// SPDX-License-Identifier: MIT
// Measures how near the proved upper bound is to the answer, and what it costs.
#include "bench/how_good/interleaved.hpp"
#include "bench/how_good/search_tables.hpp"

#include <algorithm>
#include <cstdio>

namespace maxlogdet::bench {
namespace {

// Lazy greedy without a certificate, and with one.
std::vector<Options> certified(std::size_t budget) {
  std::vector<Options> cases(2, options_of(Strategy::lazy_greedy, budget));
  cases[1].certificate = true;
  return cases;
}

void write_row(const Problem& problem) {
  const std::vector<Measured> few = measure(problem.store, certified(20));
  const std::vector<Measured> many = measure(problem.store, certified(100));
  std::printf("| %s | %s | %.4f | %.4f | %.1f |\n", problem.family.c_str(), to_string(problem.blocks), few[1].gap,
              many[1].gap, many[1].microseconds - many[0].microseconds);
}

// The maximum over all families and kinds of blocks.
void write_largest_row(std::size_t k, std::size_t n) {
  const Options options = certified(k)[1];
  double largest = 0;
  Selector selector(n);
  for_every_problem({synthetic_families(), {n}}, [&](const Problem& problem) {
    const Selection selection = selector.select(problem.store, options);
    largest = std::max(largest, selection.upper_bound - selection.log_det);
  });
  std::printf("| %zu | %zu | %.4f |\n", k, n, largest);
}

}  // namespace

void write_certificate_tables() {
  begin_table("certificates", {"family", "blocks", "k = 20: gap", "k = 100: gap", "bound, µs"});
  for_every_problem({synthetic_families(), {2000}}, write_row);

  begin_table("largest_gaps", {"k", "n", "gap"});
  for (const std::size_t k : {20U, 100U}) {
    for (const std::size_t n : {500U, 2000U, 20000U}) write_largest_row(k, n);
  }
}

}  // namespace maxlogdet::bench
