// SPDX-License-Identifier: MIT
// The same selections on one thread and on several: what threads gain over n, and what the automatic choice costs where
// one thread is best.
#include "bench/how_fast/measure.hpp"
#include "bench/world/executor.hpp"
#include "bench/world/problem.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

namespace maxlogdet::bench {
namespace {

Work selection_work(Strategy strategy, std::size_t n, int threads) {
  struct State {
    explicit State(std::size_t capacity) : selector(capacity, sim::executor()) {}
    Selector selector;
    Options options;
  };
  const BlockStore& store = stores_of("euroc_like", n, Blocks::two_rows).front();
  const auto state = std::make_shared<State>(store.size());
  state->options.strategy = strategy;
  state->options.budget = 100;
  state->options.threads = threads;
  return {[state, &store](std::size_t call) {
    state->options.stochastic.seed = call;
    state->selector.select(store, state->options);
  }};
}

void add(const std::string& kind, Strategy strategy, std::size_t n, int threads) {
  add_case(kind + "/" + to_string(strategy) + "/n:" + std::to_string(n) + "/threads:" + std::to_string(threads),
           [=] { return selection_work(strategy, n, threads); });
}

constexpr std::uint32_t trips = 20000;

// The time in which a cache line travels to another thread's core and back, `trips` times.
Work line_work() {
  return {[](std::size_t /*call*/) {
    struct alignas(128) Line {
      std::atomic<std::uint32_t> count{0};
    } line;
    const auto answer = [&line](std::uint32_t first) {  // two threads count in turn
      for (std::uint32_t next = first; next < 2 * trips; next += 2) {
        while (line.count.load(std::memory_order_acquire) != next) {
        }
        line.count.store(next + 1, std::memory_order_release);
      }
    };
    std::thread other(answer, 1U);
    answer(0U);
    other.join();
  }};
}

}  // namespace

void add_threading_cases() {
  const int most = sim::executor() == nullptr ? 1 : sim::executor()->concurrency();
  if (most == 1) return;
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
    for (const std::size_t n : {2000U, 10000U, 20000U, 50000U, 100000U}) {
      for (const int threads : {1, most}) add("threads", strategy, n, threads);
    }
  }
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
    for (const std::size_t n : {200U, 500U, 1000U, 2000U, 5000U}) {
      for (const int threads : {0, 1}) add("choose", strategy, n, threads);
    }
  }
  add_case("line/" + std::to_string(trips) + "_round_trips", line_work);
}

}  // namespace maxlogdet::bench
