// SPDX-License-Identifier: MIT
// Whether denormal float32 numbers slow a selection down, compared with normal numbers nearly as small.
#include "bench/how_good/interleaved.hpp"
#include "bench/how_good/search_tables.hpp"
#include "bench/world/latency.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

constexpr std::size_t n = 2000;
constexpr std::size_t turns = 201;
constexpr Strategy strategies[] = {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy};

// Scales every `step`-th candidate.
BlockStore scaled(const BlockStore& blocks, double scale, std::size_t step) {
  BlockStore result(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    double block[max_block_entries] = {};
    blocks.block(i, block);
    for (double& entry : block) entry *= i % step == 0 ? scale : 1;
    result.push_back(block, blocks.rows());
  }
  return result;
}

// The largest |entry|.
double largest_of(const BlockStore& blocks) {
  double largest = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    double block[max_block_entries] = {};
    blocks.block(i, block);
    for (const double entry : block) largest = std::max(largest, std::abs(entry));
  }
  return largest;
}

struct Case {
  std::string name;
  BlockStore store;
  std::size_t compared_with;  // index of another case
};

std::vector<Case> cases_of(const BlockStore& blocks) {
  const double largest = largest_of(blocks);
  const double to_normal = 1e-30 / largest;
  const double to_denormal = 1e-38 / largest;  // float32 is denormal below 1.2e-38
  std::vector<Case> cases;
  cases.push_back({"ordinary", blocks, 0});
  cases.push_back({"all at most 1e-30", scaled(blocks, to_normal, 1), 1});
  cases.push_back({"all denormal", scaled(blocks, to_denormal, 1), 1});
  cases.push_back({"one in ten at most 1e-30", scaled(blocks, to_normal, 10), 3});
  cases.push_back({"one in ten denormal", scaled(blocks, to_denormal, 10), 3});
  return cases;
}

// Median microseconds of each case; the cases take turns, so that a transient load slows all of them down.
std::vector<double> medians(const std::vector<Case>& cases, Strategy strategy) {
  Selector selector(n);
  const Options options = options_of(strategy, 100);
  std::vector<std::vector<double>> times(cases.size());
  for (std::size_t turn = 0; turn < turns; ++turn) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      times[i].push_back(microseconds_of([&] { selector.select(cases[i].store, options); }));
    }
  }
  std::vector<double> result;
  result.reserve(times.size());
  for (const std::vector<double>& of_case : times) result.push_back(sim::latency_of(of_case).median);
  return result;
}

}  // namespace

void write_denormal_table() {
  begin_table("denormals",
              {"blocks", "candidates", "`greedy` µs", "×", "`lazy_greedy` µs", "×", "`stochastic_greedy` µs", "×"});
  for (const Blocks kind : {Blocks::two_rows, Blocks::three_rows}) {
    const std::vector<Case> cases = cases_of(synthetic_store("euroc_like", n, kind, scene_seed));
    std::vector<std::vector<double>> found;
    for (const Strategy strategy : strategies) found.push_back(medians(cases, strategy));
    for (std::size_t i = 0; i < cases.size(); ++i) {
      std::printf("| %s | %s |", to_string(kind), cases[i].name.c_str());
      for (const std::vector<double>& of_strategy : found) {
        std::printf(" %.1f | %.2f |", of_strategy[i], of_strategy[i] / of_strategy[cases[i].compared_with]);
      }
      std::printf("\n");
    }
  }
}

}  // namespace maxlogdet::bench
