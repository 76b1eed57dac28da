// SPDX-License-Identifier: MIT
// The same selections on one thread and on several: what threads gain over n, where the automatic choice begins to use
// them, and what that choice costs where one thread is best.
#include "bench/how_fast/cases.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/world/executor.hpp"
#include "bench/world/problem.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace maxlogdet::bench {
namespace {

struct Point {
  std::string kind;
  Strategy strategy = Strategy::lazy_greedy;
  std::string family = "euroc_like";
  std::size_t n = 2000;
  std::size_t k = 100;
  Blocks blocks = Blocks::two_rows;
  int threads = 1;
};

std::string name_of(const Point& at) {
  return at.kind + "/" + to_string(at.strategy) + "/family:" + at.family + "/n:" + std::to_string(at.n) +
         "/k:" + std::to_string(at.k) + "/blocks:" + to_string(at.blocks) + "/threads:" + std::to_string(at.threads);
}

struct State {
  explicit State(std::size_t capacity) : selector(capacity, sim::executor()) {}
  Selector selector;
  Options options;
  Selection selection{};
};

// Sleeps for `pause` after each call, as a tracker waits for the next frame.
Work selection_work(const Point& at, std::chrono::milliseconds pause) {
  const BlockStore& store = stores_of(at.family, at.n, at.blocks).front();
  const auto state = std::make_shared<State>(store.size());
  state->options.strategy = at.strategy;
  state->options.budget = at.k;
  state->options.threads = at.threads;
  const auto run = [state, &store](std::size_t call) {
    state->options.stochastic.seed = call;
    state->selection = state->selector.select(store, state->options);
  };
  const auto record = [state, pause](std::size_t /*call*/, Sums& sums) {
    sums["threads"] += state->selection.threads;
    if (pause.count() > 0) std::this_thread::sleep_for(pause);
  };
  return {run, record};
}

void add(const Point& at, std::chrono::milliseconds pause = {}) {
  add_case(name_of(at), [=] { return selection_work(at, pause); });
}

// The time until all of several concurrent callers have finished, each with a serial selector of its own.
Work side_by_side_work(const Point& at, int callers) {
  constexpr int selections_each = 200;  // about 10 ms, so that starting threads does not matter
  const BlockStore& store = stores_of(at.family, at.n, at.blocks).front();
  const auto run = [&store, callers, k = at.k](std::size_t /*call*/) {
    const auto select = [&store, k] {
      Selector selector(store.size());
      Options options;
      options.budget = k;
      for (int i = 0; i < selections_each; ++i) selector.select(store, options);
    };
    std::vector<std::thread> others;
    for (int i = 1; i < callers; ++i) others.emplace_back(select);
    select();
    for (std::thread& other : others) other.join();
  };
  return {run, {}};
}

constexpr std::uint32_t trips = 20000;

// The time in which a cache line travels to another thread's core and back, `trips` times.
Work line_work() {
  const auto run = [](std::size_t /*call*/) {
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
  };
  return {run, {}};
}

int max_threads() { return sim::executor() == nullptr ? 1 : std::max(1, sim::executor()->concurrency()); }

// 1, 2, 4, ... and as many as the executor offers.
std::vector<int> thread_counts() {
  std::vector<int> counts;
  for (int count = 1; count < max_threads(); count *= 2) counts.push_back(count);
  counts.push_back(max_threads());
  return counts;
}

void add_over_n() {
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
    for (const std::size_t n : {2000U, 5000U, 10000U, 20000U, 50000U, 100000U}) {
      for (const int count : thread_counts()) add({"threads", strategy, "euroc_like", n, 100, Blocks::two_rows, count});
    }
    for (const int count : thread_counts()) {
      add({"threads", strategy, "euroc_like", 100000, 200, Blocks::two_rows, count});
      add({"threads", strategy, "euroc_like", 100000, 200, Blocks::two_rows_measurement, count});
    }
  }
}

// Problems for which one thread is best.
std::vector<Point> small_problems() {
  std::vector<Point> points;
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
    for (const std::size_t n : {200U, 500U, 1000U, 2000U, 5000U}) {
      points.push_back({"choose", strategy, "euroc_like", n});
    }
    for (const std::size_t k : {20U, 200U}) points.push_back({"choose", strategy, "euroc_like", 2000, k});
    for (const Blocks blocks : {Blocks::two_rows_measurement, Blocks::three_rows, Blocks::three_rows_measurement}) {
      points.push_back({"choose", strategy, "euroc_like", 2000, 100, blocks});
    }
    for (const std::string& family : synthetic_families()) {
      if (family != "euroc_like") points.push_back({"choose", strategy, family});
    }
  }
  return points;
}

// What the automatic choice (threads: 0) costs there.
void add_automatic_choice() {
  for (Point at : small_problems()) {
    for (const int count : {0, 1}) {
      at.threads = count;
      add(at);
    }
  }
}

void add_after_pause() {
  for (const int count : {1, max_threads()}) {
    add({"after_pause", Strategy::greedy, "euroc_like", 20000, 100, Blocks::two_rows, count},
        std::chrono::milliseconds(33));
  }
}

void add_side_by_side() {
  for (const int callers : {1, max_threads()}) {
    const Point at{"side_by_side", Strategy::lazy_greedy, "euroc_like", 2000, 100, Blocks::two_rows, callers};
    add_case(name_of(at), [=] { return side_by_side_work(at, callers); });
  }
}

}  // namespace

void add_threading_cases() {
  add_over_n();
  add_automatic_choice();
  add_after_pause();
  add_side_by_side();
  if (max_threads() > 1) add_case("line/" + std::to_string(trips) + "_round_trips/threads:2", line_work);
}

}  // namespace maxlogdet::bench
