// SPDX-License-Identifier: MIT
// Measures the convex relaxation: certificates, and the relaxed strategy.
#include "bench/how_good/interleaved.hpp"
#include "bench/how_good/search_tables.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace maxlogdet::bench {
namespace {

constexpr std::size_t budgets[] = {60, 100, 200, 500};

// Lazy greedy without a certificate, with one, and with one after 1 and 8 passes.
std::vector<Options> certified(std::size_t budget) {
  std::vector<Options> cases(4, options_of(Strategy::lazy_greedy, budget));
  for (std::size_t i = 1; i < 4; ++i) cases[i].certificate.compute = true;
  cases[2].certificate.passes = 1;
  cases[3].certificate.passes = 8;
  return cases;
}

std::vector<Options> lazy_and_relaxed(std::size_t budget) {
  return {options_of(Strategy::lazy_greedy, budget), options_of(Strategy::relaxed, budget)};
}

void write_certificate_row(const Problem& problem) {
  const std::vector<Measured> few = measure(problem.store, certified(20));
  const std::vector<Measured> many = measure(problem.store, certified(100));
  std::printf("| %s | %s | %.4f | %.4f | %.4f | %.4f | %.4f | %.4f | %.1f | %.1f |\n", problem.family.c_str(),
              to_string(problem.blocks), few[1].gap, few[2].gap, few[3].gap, many[1].gap, many[2].gap, many[3].gap,
              many[1].microseconds - many[0].microseconds, (many[3].microseconds - many[1].microseconds) / 8);
}

// Maxima over all families and kinds of blocks.
void write_largest_gaps_row(std::size_t k, std::size_t n) {
  const std::vector<Options> cases = certified(k);
  double largest[4] = {};
  Selector selector(n);
  for_every_problem({synthetic_families(), {n}}, [&](const Problem& problem) {
    for (std::size_t i = 1; i < 4; ++i) {
      const Selection selection = selector.select(problem.store, cases[i]);
      largest[i] = std::max(largest[i], selection.upper_bound - selection.log_det);
    }
  });
  std::printf("| %zu | %zu | %.4f | %.4f | %.4f |\n", k, n, largest[1], largest[2], largest[3]);
}

// One cell per budget: how many times faster than lazy greedy, and the difference of log det.
void write_relaxed_cells(const BlockStore& store) {
  for (const std::size_t k : budgets) {
    const std::vector<Measured> found = measure(store, lazy_and_relaxed(k));
    std::printf(" %.1f, %+.4f |", found[0].microseconds / found[1].microseconds, found[1].log_det - found[0].log_det);
  }
  std::printf("\n");
}

// These frames have other seeds than those of the other tables.
void write_relaxed_frames_row(const std::string& family) {
  Frames frames = {{family}, {1000, 2000, 5000, 20000}, std::vector<std::uint64_t>(20)};
  std::iota(frames.seeds.begin(), frames.seeds.end(), scene_seed + 1);
  double lowest = 0, highest = 0, sum = 0;
  int selections = 0, below = 0;
  for_every_problem(frames, [&](const Problem& problem) {
    Selector selector(problem.n);
    for (const std::size_t k : budgets) {
      const std::vector<Options> cases = lazy_and_relaxed(k);
      const double lazy = selector.select(problem.store, cases[0]).log_det;
      const double delta = selector.select(problem.store, cases[1]).log_det - lazy;
      lowest = std::min(lowest, delta);
      highest = std::max(highest, delta);
      sum += delta;
      below += delta < -1e-3 ? 1 : 0;
      ++selections;
    }
  });
  std::printf("| %s | %d | %+.4f | %+.4f | %+.4f | %d |\n", family.c_str(), selections, lowest, sum / selections,
              highest, below);
}

}  // namespace

void write_certificate_tables() {
  begin_table("certificates", {"family", "blocks", "k = 20: gap", "1 pass", "8 passes", "k = 100: gap", "1 pass",
                               "8 passes", "bound, µs", "a pass, µs"});
  for_every_problem({synthetic_families(), {2000}}, write_certificate_row);

  begin_table("largest_gaps", {"k", "n", "gap", "1 pass", "8 passes"});
  for (const std::size_t k : {20U, 100U}) {
    for (const std::size_t n : {500U, 2000U, 20000U}) write_largest_gaps_row(k, n);
  }
}

void write_relaxed_tables() {
  begin_table("relaxed", {"family", "blocks", "n", "k = 60", "k = 100", "k = 200", "k = 500"});
  for_every_problem({synthetic_families(), {20000, 100000}}, [](const Problem& problem) {
    std::printf("| %s | %s | %zu |", problem.family.c_str(), to_string(problem.blocks), problem.n);
    write_relaxed_cells(problem.store);
  });

  begin_table("relaxed_over_n", {"n", "k = 60", "k = 100", "k = 200", "k = 500"});
  for (const std::size_t n : {1000U, 2000U, 5000U, 10000U, 20000U, 50000U, 100000U}) {
    std::printf("| %zu |", n);
    write_relaxed_cells(synthetic_store("euroc_like", n, Blocks::two_rows, scene_seed));
  }

  begin_table("relaxed_frames", {"family", "selections", "lowest Δ", "mean Δ", "highest Δ", "below -0.001"});
  for (const std::string& family : scene_families()) write_relaxed_frames_row(family);
}

}  // namespace maxlogdet::bench
