// SPDX-License-Identifier: MIT
// Measures what an answer is worth that the deadline has filled: the same selections with all the time, with none, and
// random ones of the same size.
#include "bench/how_good/interleaved.hpp"
#include "bench/how_good/search_tables.hpp"
#include "bench/world/draws.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace maxlogdet::bench {
namespace {

constexpr int draws_per_problem = 10;

// Nats below the answer with all the time.
class Loss {
 public:
  void add(double loss) {
    sum_ += loss;
    worst_ = std::max(worst_, loss);
    ++count_;
  }
  double mean() const { return sum_ / count_; }
  double worst() const { return worst_; }

 private:
  double sum_ = 0, worst_ = 0;
  int count_ = 0;
};

// The log det of k valid candidates drawn at random: of a store that has no others.
double log_det_of_random(const BlockStore& store, std::size_t k, sim::Draws& draws) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < store.size(); ++i) {
    if (store.is_valid(i)) order.push_back(i);
  }
  draws.shuffle_front(order, k);
  BlockStore drawn(k);
  for (std::size_t i = 0; i < k; ++i) {
    double block[max_block_entries];
    const int rows = store.block(order[i], block);
    drawn.push_back(block, rows);
  }
  Selector selector(k);
  return selector.select(drawn, options_of(Strategy::lazy_greedy, k)).log_det;
}

// Means over the frames, and the worst of them.
void write_row(std::size_t n, std::size_t k) {
  std::vector<Options> cases(2, options_of(Strategy::lazy_greedy, k));
  cases[1].time_limit = 1e-9;
  Loss filled, random;
  double unlimited_us = 0, filled_us = 0;
  int problems = 0;
  sim::Draws draws(scene_seed);
  for_every_problem({scene_families(), {n}}, [&](const Problem& problem) {
    const std::vector<Measured> found = measure(problem.store, cases);
    unlimited_us += found[0].microseconds;
    filled_us += found[1].microseconds;
    filled.add(found[0].log_det - found[1].log_det);
    for (int i = 0; i < draws_per_problem; ++i) {
      random.add(found[0].log_det - log_det_of_random(problem.store, k, draws));
    }
    ++problems;
  });
  std::printf("| %zu | %zu | %.1f | %.1f | %.2f | %.2f | %.2f | %.2f |\n", n, k, unlimited_us / problems,
              filled_us / problems, filled.mean(), filled.worst(), random.mean(), random.worst());
}

}  // namespace

void write_deadline_table() {
  begin_table("deadline", {"n", "k", "µs without a limit", "µs, 1 ns", "nats lost", "worst", "nats lost by random ones",
                           "worst of these"});
  for (const std::size_t n : {200U, 465U, 2000U}) write_row(n, 100);
  write_row(2000, 200);
}

}  // namespace maxlogdet::bench
