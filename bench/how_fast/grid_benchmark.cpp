// SPDX-License-Identifier: MIT
// select() from a filled store, and Eigen's selections from the same blocks: a grid of n, k, epsilon and instruction
// sets, and other blocks and frames at its base point.
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/world/names.hpp"
#include "bench/world/problem.hpp"
#include "tests/support/processor.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

struct Point {
  Strategy strategy = Strategy::lazy_greedy;
  std::string family = "euroc_like";
  std::size_t n = 2000;
  std::size_t k = 100;
  Blocks blocks = Blocks::two_rows;
  double epsilon = 0.1;  // of stochastic greedy
  std::string isa = active_isa();

  bool is_stochastic() const { return strategy == Strategy::stochastic_greedy; }
};

std::string name_of(const std::string& method, const Point& at, const std::string& isa) {
  char epsilon[32] = "";
  if (at.is_stochastic()) std::snprintf(epsilon, sizeof epsilon, "/epsilon:%g", at.epsilon);
  return "grid/" + method + "/family:" + at.family + "/n:" + std::to_string(at.n) + "/k:" + std::to_string(at.k) +
         "/blocks:" + to_string(at.blocks) + epsilon + "/isa:" + isa;
}

Work library_work(const Point& at) {
  struct State {
    explicit State(std::size_t capacity) : selector(capacity) {}
    Selector selector;
    Options options;
    Selection selection{};
  };
  const auto& stores = stores_of(at.family, at.n, at.blocks);
  std::size_t capacity = 0;
  for (const BlockStore& store : stores) capacity = std::max(capacity, store.size());
  const test::ForcedIsa forced(at.isa.c_str());
  const auto state = std::make_shared<State>(capacity);
  state->options.strategy = at.strategy;
  state->options.budget = at.k;
  state->options.stochastic.epsilon = at.epsilon;
  const auto run = [state, &stores](std::size_t call) {
    state->options.stochastic.seed = call;
    state->selection = state->selector.select(stores[call % stores.size()], state->options);
  };
  const auto record = [state](std::size_t /*call*/, Sums& sums) { sums["log_det"] += state->selection.log_det; };
  return {run, record, {}, stores.size()};
}

Work eigen_work(const Point& at) {
  const auto& stores = stores_of(at.family, at.n, at.blocks);
  const std::shared_ptr<EigenSelector> selector = make_eigen_selector(stores.front());
  const auto run = [selector, at](std::size_t call) {
    if (at.is_stochastic()) return selector->stochastic_greedy(at.k, at.epsilon, call);
    selector->lazy_greedy(at.k);
  };
  const auto load = [selector, &stores](std::size_t call) { selector->load(stores[call % stores.size()]); };
  return {run, {}, load, stores.size()};
}

void add(const Point& at) {
  add_case(name_of(to_string(at.strategy), at, at.isa), [at] { return library_work(at); });
}

// Eigen's counterpart of the two strategies that save evaluations; of greedy there is none.
void add_eigen(const Point& at) {
  const char* const method = at.is_stochastic() ? "eigen_stochastic" : "eigen_lazy_scan";
  add_case(name_of(method, at, "native"), [at] { return eigen_work(at); });
}

constexpr Strategy strategies[] = {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy};

std::vector<double> epsilons_of(Strategy strategy) {
  if (strategy == Strategy::stochastic_greedy) return {0.5, 0.1, 0.01};
  return {0.1};
}

void add_grid() {
  Point at;
  for (const Strategy strategy : strategies) {
    at.strategy = strategy;
    for (const std::size_t n : {200U, 465U, 2000U, 20000U}) {
      at.n = n;
      for (const std::size_t k : {50U, 100U, 200U}) {
        at.k = k;
        for (const double epsilon : epsilons_of(strategy)) {
          at.epsilon = epsilon;
          for (const std::string& isa : sim::supported_isas()) {
            at.isa = isa;
            add(at);
          }
          if (strategy != Strategy::greedy) add_eigen(at);
        }
      }
    }
  }
}

void add_other_frames() {
  Point at;
  const auto add_both = [&at] {
    add(at);
    add_eigen(at);
  };
  for (const Blocks blocks : {Blocks::three_rows, Blocks::two_rows_measurement}) {
    at.blocks = blocks;
    add_both();
  }
  at = Point();
  at.family = "nearly_equal_gains";
  add_both();
  at.family = real_frames;
  if (real_frames_folder().empty()) {
    std::fprintf(stderr, "real frames are skipped: their folder is missing; MAXLOGDET_DATA names it\n");
  } else {
    add_both();
  }
}

}  // namespace

void add_grid_cases() {
  add_grid();
  add_other_frames();
}

}  // namespace maxlogdet::bench
