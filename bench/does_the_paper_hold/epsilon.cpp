// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/epsilon.hpp"

#include "bench/world/draws.hpp"
#include "bench/world/latency.hpp"
#include "bench/world/projection.hpp"
#include "bench/world/scene.hpp"

#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>

namespace maxlogdet::sim {
namespace {

constexpr double prior = 1e-5;  // times I

struct Timed {
  double f = 0;  // log det less that of the prior
  double us = 0;
};

Timed timed_select(Selector& selector, const BlockStore& blocks, Options options) {
  const Eigen::Matrix<double, 6, 6> information = prior * Eigen::Matrix<double, 6, 6>::Identity();
  options.prior = information.data();
  options.threads = 1;
  double log_det = 0;
  const Latency latency = measure_latency("select", 3, [&] { log_det = selector.select(blocks, options).log_det; });
  return {log_det - 6 * std::log(prior), latency.median};
}

// Algorithm 1 with epsilon = 1 samples no candidate. A round needs at least one, and this epsilon asks for less than
// one.
double usable_epsilon(double epsilon, std::size_t n, std::size_t k) {
  return epsilon < 1 ? epsilon : std::exp(-0.5 * static_cast<double>(k) / static_cast<double>(n));
}

double gains_asked_for(std::size_t n, std::size_t k, std::size_t sample) {
  double gains = 0;
  for (std::size_t i = 0; i < k; ++i) gains += static_cast<double>(std::min(sample, n - i));
  return gains;
}

std::vector<std::string> row_of(const std::string& grid, double epsilon, const std::vector<EpsilonOutcome>& outcomes) {
  double lowest = 1e300, gains = 0, greedy = 0, lazy = 0;
  for (const EpsilonOutcome& o : outcomes) {
    lowest = std::min(lowest, o.share_of_greedy);
    gains += o.gains_greedy / o.gains;
    greedy += o.us_greedy / o.us;
    lazy += o.us_lazy / o.us;
  }
  const auto count = static_cast<double>(outcomes.size());
  const double guarantee = 1 - std::exp(-1.0) - epsilon;
  return {grid,
          exact(epsilon),
          guarantee > 0 ? fixed(guarantee, 3) : "none",
          fixed(lowest, 4),
          fixed(gains / count, 1),
          fixed(greedy / count, 1),
          fixed(lazy / count, 1)};
}

}  // namespace

std::vector<EpsilonOutcome> run_epsilon(const EpsilonOptions& options, std::size_t n, std::uint64_t run) {
  Draws seeds(options.seed, run);
  const Frame frame = make_scene(Scene::euroc_like, n, seeds.bits());
  BlockStore blocks;
  for (const Match& match : frame.matches) append_paper_block(pose_of(frame.T_cw_prior), match, blocks);
  Selector selector(n);
  std::vector<EpsilonOutcome> outcomes;
  for (const double share : options.shares) {
    const auto k = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(share * static_cast<double>(n))));
    Options search;
    search.budget = k;
    search.strategy = Strategy::greedy;
    const Timed greedy = timed_select(selector, blocks, search);
    search.strategy = Strategy::lazy_greedy;
    const Timed lazy = timed_select(selector, blocks, search);
    search.strategy = Strategy::stochastic_greedy;
    for (const double epsilon : options.epsilons) {
      search.stochastic.epsilon = usable_epsilon(epsilon, n, k);
      search.stochastic.seed = seeds.bits();
      const Timed found = timed_select(selector, blocks, search);
      const double sample = static_cast<double>(n) / static_cast<double>(k) * std::log(1 / search.stochastic.epsilon);
      outcomes.push_back({n, k, epsilon, found.us, greedy.us, lazy.us,
                          gains_asked_for(n, k, static_cast<std::size_t>(std::ceil(sample))), gains_asked_for(n, k, n),
                          found.f / greedy.f});
    }
  }
  return outcomes;
}

Table epsilon_table(const EpsilonOptions& options, const std::vector<EpsilonOutcome>& outcomes) {
  Table table;
  table.header = {"n and k",
                  "epsilon",
                  "guarantee",
                  "minimum of greedy",
                  "fewer evaluations",
                  "faster than greedy",
                  "faster than lazy greedy"};
  for (const bool is_papers : {false, true}) {
    for (const double epsilon : options.epsilons) {
      std::vector<EpsilonOutcome> chosen;
      for (const EpsilonOutcome& o : outcomes) {
        if (o.epsilon == epsilon && (!is_papers || (o.n == 1000 && o.k == 100))) chosen.push_back(o);
      }
      if (!chosen.empty()) table.rows.push_back(row_of(is_papers ? "n = 1000 k = 100" : "all", epsilon, chosen));
    }
  }
  return table;
}

}  // namespace maxlogdet::sim
