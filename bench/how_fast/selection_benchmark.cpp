// SPDX-License-Identifier: MIT
// select() from a filled store, and the baselines in Eigen on the same blocks.
#include "bench/how_fast/cases.hpp"
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/world/names.hpp"
#include "bench/world/problem.hpp"
#include "tests/support/forced_isa.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

// The grid's base point, and the values of axes that several parts of the grid have.
constexpr std::size_t base_n = 2000;
constexpr std::size_t base_k = 100;
constexpr Blocks base_blocks = Blocks::two_rows;
constexpr double base_epsilon = 0.1;
using Epsilons = std::vector<double>;
Epsilons all_epsilons() { return {0.5, base_epsilon, 0.01}; }
using BlockKinds = std::vector<Blocks>;
BlockKinds all_kinds() {
  return {Blocks::one_row, Blocks::two_rows, Blocks::two_rows_measurement, Blocks::three_rows,
          Blocks::three_rows_measurement};
}

struct Point {
  std::string family = "euroc_like";
  std::size_t n = base_n;
  std::size_t k = base_k;
  Blocks blocks = base_blocks;
  double epsilon = base_epsilon;
  std::string isa = active_isa();
};

std::string shown(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

// KIND/METHOD/KEY:VALUE/..., which bench/how_fast/results.py parses.
std::string name_of(const std::string& kind, const std::string& method, const Point& at, bool is_stochastic,
                    const std::string& isa) {
  return kind + "/" + method + "/family:" + at.family +
         "/n:" + (at.family == real_frames ? "all" : std::to_string(at.n)) + "/k:" + std::to_string(at.k) +
         "/blocks:" + to_string(at.blocks) + (is_stochastic ? "/epsilon:" + shown(at.epsilon) : "") + "/isa:" + isa;
}

// The number of positions at which two answers differ.
double mismatches(const std::uint32_t* indices, std::size_t size, const std::vector<std::uint32_t>& exact) {
  std::size_t count = std::max(size, exact.size());
  for (std::size_t i = 0; i < std::min(size, exact.size()); ++i) count -= indices[i] == exact[i] ? 1 : 0;
  return static_cast<double>(count);
}

Work library_work(Strategy strategy, const Point& at) {
  const auto& stores = stores_of(at.family, at.n, at.blocks);
  const auto& exact = exact_answers(at.family, at.n, at.blocks, at.k);
  std::size_t capacity = at.k;
  for (const BlockStore& store : stores) capacity = std::max(capacity, store.size());
  const test::ForcedIsa forced(at.isa.c_str());

  struct State {
    Selector selector;
    Options options;
    Selection selection;
  };
  const auto state = std::make_shared<State>(State{Selector(capacity), Options(), Selection()});
  state->options.strategy = strategy;
  state->options.budget = at.k;
  state->options.stochastic.epsilon = at.epsilon;
  const auto run = [state, &stores](std::size_t call) {
    state->options.stochastic.seed = call;
    state->selection = state->selector.select(stores[call % stores.size()], state->options);
  };
  const auto record = [state, &stores, &exact](std::size_t call, Sums& sums) {
    const Selection& selection = state->selection;
    const ExactAnswer& answer = exact[call % stores.size()];
    sums["candidates"] += static_cast<double>(stores[call % stores.size()].size());
    sums["delta_nats"] += selection.log_det - answer.log_det;
    sums["evaluations"] += static_cast<double>(selection.evaluations);
    sums["float64_decisions"] += static_cast<double>(selection.float64_decisions);
    if (state->options.strategy != Strategy::stochastic_greedy) {
      sums["mismatches"] += mismatches(selection.indices, selection.size, answer.indices);
    }
  };
  return {run, record};
}

Work eigen_work(EigenMethod method, const Point& at) {
  const auto& exact = exact_answers(at.family, at.n, at.blocks, at.k);
  using Selectors = std::vector<std::unique_ptr<EigenSelector>>;
  const auto selectors = std::make_shared<Selectors>();
  for (const BlockStore& store : stores_of(at.family, at.n, at.blocks)) {
    selectors->push_back(make_eigen_selector(method, store));
  }
  const auto& stores = stores_of(at.family, at.n, at.blocks);
  const auto run = [selectors, at](std::size_t call) {
    (*selectors)[call % selectors->size()]->select(at.k, at.epsilon, call);
  };
  const auto record = [selectors, method, &stores, &exact](std::size_t call, Sums& sums) {
    const std::size_t frame = call % selectors->size();
    const EigenSelector& selector = *(*selectors)[frame];
    sums["candidates"] += static_cast<double>(stores[frame].size());
    sums["delta_nats"] += selector.log_det() - exact[frame].log_det;
    sums["evaluations"] += static_cast<double>(selector.evaluations());
    if (method != EigenMethod::stochastic && method != EigenMethod::log_det) {
      sums["mismatches"] += mismatches(selector.indices().data(), selector.indices().size(), exact[frame].indices);
    }
  };
  return {run, record};
}

// Registers each name once: several axes of the grid meet in its base point.
class Cases {
 public:
  void library(Strategy strategy, const Point& at) {
    const bool is_stochastic = strategy == Strategy::stochastic_greedy;
    const std::string name = name_of("select", to_string(strategy), at, is_stochastic, at.isa);
    if (added_.insert(name).second) add_case(name, [=] { return library_work(strategy, at); });
  }

  void eigen(EigenMethod method, const Point& at) {
    const bool is_stochastic = method == EigenMethod::stochastic || method == EigenMethod::log_det;
    const std::string name = name_of("select", to_string(method), at, is_stochastic, "native");
    if (added_.insert(name).second) add_case(name, [=] { return eigen_work(method, at); });
  }

  void every_strategy(Point at, const Epsilons& epsilons) {
    library(Strategy::greedy, at);
    library(Strategy::lazy_greedy, at);
    for (const double epsilon : epsilons) {
      at.epsilon = epsilon;
      library(Strategy::stochastic_greedy, at);
    }
  }

  void every_baseline(Point at, const Epsilons& epsilons) {
    for (const double epsilon : epsilons) {
      at.epsilon = epsilon;
      for (const EigenMethod method : eigen_methods) eigen(method, at);
    }
  }

 private:
  std::set<std::string> added_;
};

void add_sizes_and_budgets(const BlockKinds& kinds, Cases& cases) {
  const auto add = [&cases](const Point& at) {
    cases.every_strategy(at, all_epsilons());
    cases.every_baseline(at, {base_epsilon});
  };
  Point at;
  for (const Blocks blocks : kinds) {
    at.blocks = blocks;
    for (const std::size_t n : {200U, 500U, 1000U, 2000U, 5000U, 20000U, 100000U}) {
      at.n = n;
      add(at);
    }
    at.n = base_n;
    for (const std::size_t k : {20U, 60U, 100U, 200U}) {
      at.k = k;
      add(at);
    }
    at.k = base_k;
  }
}

void add_block_kinds(Cases& cases) {
  Point at;
  for (const Blocks blocks : all_kinds()) {
    at.blocks = blocks;
    cases.every_strategy(at, all_epsilons());
    cases.every_baseline(at, all_epsilons());
  }
}

void add_instruction_sets(const BlockKinds& kinds, Cases& cases) {
  Point at;
  for (const std::string& isa : sim::supported_isas()) {
    at.isa = isa;
    for (const Blocks blocks : kinds) {
      at.blocks = blocks;
      cases.every_strategy(at, {base_epsilon});
    }
  }
}

void add_families(const BlockKinds& kinds, const Epsilons& epsilons, Cases& cases) {
  std::vector<std::string> families = synthetic_families();
  if (real_frames_folder().empty()) {
    std::fprintf(stderr, "real frames are skipped: their folder is missing; MAXLOGDET_DATA names it\n");
  } else {
    families.emplace_back(real_frames);
  }
  Point at;
  for (const std::string& family : families) {
    at.family = family;
    for (const Blocks blocks : kinds) {
      at.blocks = blocks;
      cases.every_strategy(at, epsilons);
      cases.every_baseline(at, {base_epsilon});
    }
  }
}

// A full round as greedy pays for it: its time divided by its rounds includes the factor's update and the choice.
// profiles/roofline measures the kernel alone.
void add_full_rounds() {
  Point at;
  for (const Blocks blocks : {Blocks::one_row, Blocks::two_rows, Blocks::three_rows}) {
    at.blocks = blocks;
    add_case(name_of("full_round", "greedy", at, false, at.isa), [=] { return library_work(Strategy::greedy, at); });
  }
}

void add_many_calls() {
  constexpr std::size_t many_calls = 100000;
  const Point base;
  add_case(
      name_of("many_calls", "lazy_greedy", base, false, base.isa),
      [=] { return library_work(Strategy::lazy_greedy, base); }, many_calls);
}

}  // namespace

void add_selection_cases(bool full) {
  Cases cases;
  add_sizes_and_budgets(full ? all_kinds() : BlockKinds{base_blocks}, cases);
  add_block_kinds(cases);
  add_instruction_sets(full ? all_kinds() : BlockKinds{Blocks::two_rows, Blocks::three_rows}, cases);
  add_families(full ? all_kinds() : BlockKinds{base_blocks}, full ? all_epsilons() : Epsilons{base_epsilon}, cases);
  add_full_rounds();
  add_many_calls();
}

}  // namespace maxlogdet::bench
