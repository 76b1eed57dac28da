// SPDX-License-Identifier: MIT
// select() from a filled store, and the baselines in Eigen on the same blocks.
#include "bench/cases.hpp"
#include "bench/eigen_baselines.hpp"
#include "bench/measure.hpp"
#include "bench/problem.hpp"
#include "sim/names.hpp"
#include "tests/support/forced_isa.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

// Where in the grid; the defaults are its base point.
struct Point {
  std::string family = "euroc_like";
  std::size_t n = 2000;
  std::size_t k = 100;
  Blocks blocks = Blocks::two_rows;
  double epsilon = 0.1;
  std::string isa = active_isa();
};

std::string shown(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

// FAMILY/KEY:VALUE/..., which bench/results.py takes apart.
std::string name_of(const std::string& kind, const std::string& method, const Point& at, bool is_stochastic,
                    const std::string& isa) {
  return kind + "/" + method + "/family:" + at.family +
         "/n:" + (at.family == real_frames ? "all" : std::to_string(at.n)) + "/k:" + std::to_string(at.k) +
         "/blocks:" + to_string(at.blocks) + (is_stochastic ? "/epsilon:" + shown(at.epsilon) : "") + "/isa:" + isa;
}

// Positions at which two answers differ.
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
  const sim::ForcedIsa forced(at.isa.c_str());

  struct State {
    Selector selector;
    Options options;
    Selection selection;
  };
  const auto state = std::make_shared<State>(State{Selector(capacity), Options(), Selection()});
  state->options.strategy = strategy;
  state->options.budget = at.k;
  state->options.epsilon = at.epsilon;
  const auto run = [state, &stores](std::size_t call) {
    state->options.seed = call;
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

// Cases by name, so that axes may meet.
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

  void every_strategy(Point at, const std::vector<double>& epsilons) {
    library(Strategy::greedy, at);
    library(Strategy::lazy_greedy, at);
    for (const double epsilon : epsilons) {
      at.epsilon = epsilon;
      library(Strategy::stochastic_greedy, at);
    }
  }

  void every_baseline(Point at, const std::vector<double>& epsilons) {
    for (const double epsilon : epsilons) {
      at.epsilon = epsilon;
      for (const EigenMethod method : eigen_methods) eigen(method, at);
    }
  }

 private:
  std::set<std::string> added_;
};

}  // namespace

void add_selection_cases(bool full) {
  const std::vector<std::size_t> sizes = {200, 500, 1000, 2000, 5000, 20000, 100000};
  const std::vector<std::size_t> budgets = {20, 60, 100, 200};
  const std::vector<double> epsilons = {0.5, 0.1, 0.01};
  const std::vector<Blocks> kinds = {Blocks::one_row, Blocks::two_rows, Blocks::two_rows_measurement,
                                     Blocks::three_rows, Blocks::three_rows_measurement};
  const Point base;
  Cases cases;

  const std::vector<Blocks> kinds_over_n = full ? kinds : std::vector<Blocks>{base.blocks};
  for (const Blocks blocks : kinds_over_n) {
    for (const std::size_t n : sizes) {
      Point at;
      at.n = n;
      at.blocks = blocks;
      cases.every_strategy(at, epsilons);
      cases.every_baseline(at, {base.epsilon});
    }
    for (const std::size_t k : budgets) {
      Point at;
      at.k = k;
      at.blocks = blocks;
      cases.every_strategy(at, epsilons);
      cases.every_baseline(at, {base.epsilon});
    }
  }
  for (const Blocks blocks : kinds) {
    Point at;
    at.blocks = blocks;
    cases.every_strategy(at, epsilons);
    cases.every_baseline(at, epsilons);
  }
  for (const std::string& isa : sim::supported_isas()) {
    for (const Blocks blocks : full ? kinds : std::vector<Blocks>{Blocks::two_rows, Blocks::three_rows}) {
      Point at;
      at.isa = isa;
      at.blocks = blocks;
      cases.every_strategy(at, {base.epsilon});
    }
  }
  std::vector<std::string> families = synthetic_families();
  if (real_frames_folder().empty()) {
    std::fprintf(stderr, "no real frames here, skipped; MAXLOGDET_DATA names their folder\n");
  } else {
    families.emplace_back(real_frames);
  }
  for (const std::string& family : families) {
    for (const Blocks blocks : full ? kinds : std::vector<Blocks>{base.blocks}) {
      Point at;
      at.family = family;
      at.blocks = blocks;
      cases.every_strategy(at, full ? epsilons : std::vector<double>{base.epsilon});
      cases.every_baseline(at, {base.epsilon});
    }
  }

  // A full round as greedy pays for it: its time by its rounds, with the update of the factor and the choice. The
  // kernel by itself is in profiles/roofline.
  for (const Blocks blocks : {Blocks::one_row, Blocks::two_rows, Blocks::three_rows}) {
    Point at;
    at.blocks = blocks;
    add_case(name_of("full_round", "greedy", at, false, at.isa), [=] { return library_work(Strategy::greedy, at); });
  }
  constexpr std::size_t many_calls = 100000;
  add_case(
      name_of("many_calls", "lazy_greedy", base, false, base.isa),
      [=] { return library_work(Strategy::lazy_greedy, base); }, many_calls);
}

}  // namespace maxlogdet::bench
