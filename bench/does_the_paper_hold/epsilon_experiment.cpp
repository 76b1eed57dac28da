// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/epsilon_experiment.hpp"

#include "bench/world/draws.hpp"
#include "bench/world/latency.hpp"

#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace maxlogdet::sim {
namespace {

constexpr double p = 1e-5;  // the prior p I, of which the recorded results are
constexpr double prior[36] = {p, 0, 0, 0, 0, 0, 0, p, 0, 0, 0, 0, 0, 0, p, 0, 0, 0,
                              0, 0, 0, p, 0, 0, 0, 0, 0, 0, p, 0, 0, 0, 0, 0, 0, p};
constexpr double log_det_prior = 6 * -11.512925464970229;

struct Timed {
  std::set<std::uint32_t> indices;
  double log_det = 0;
  double us = 0;
};

Timed timed_select(Selector& selector, const BlockStore& blocks, const Options& options) {
  Selection selection{};
  constexpr std::size_t repeat = 3;
  const Latency latency = measure_latency("select", repeat, [&] { selection = selector.select(blocks, options); });
  return {{selection.begin(), selection.end()}, selection.log_det, latency.median};
}

// Algorithm 1 with epsilon = 1 samples no candidate. A round needs at least one, and this epsilon asks for less than
// one.
double usable_epsilon(double epsilon, std::size_t n, std::size_t k) {
  return epsilon < 1 ? epsilon : std::exp(-0.5 * static_cast<double>(k) / static_cast<double>(n));
}

Options options_of(std::size_t k, Strategy strategy) {
  Options search;
  search.budget = k;
  search.threads = 1;
  search.strategy = strategy;
  search.prior = prior;
  return search;
}

// What stochastic greedy is compared with.
struct Reference {
  Timed greedy;
  Timed lazy;
};

Reference reference_of(Selector& selector, const BlockStore& blocks, std::size_t k) {
  return {timed_select(selector, blocks, options_of(k, Strategy::greedy)),
          timed_select(selector, blocks, options_of(k, Strategy::lazy_greedy))};
}

double gains_asked_for(std::size_t n, std::size_t k, std::size_t sample) {
  double gains = 0;
  for (std::size_t i = 0; i < k; ++i) gains += static_cast<double>(std::min(sample, n - i));
  return gains;
}

EpsilonOutcome outcome_of(std::size_t n, std::size_t k, double epsilon, const Timed& found,
                          const Reference& reference) {
  const Timed& greedy = reference.greedy;
  EpsilonOutcome outcome;
  outcome.n = n;
  outcome.k = k;
  outcome.us = found.us;
  outcome.us_greedy = greedy.us;
  outcome.us_lazy = reference.lazy.us;
  outcome.gap_nats = greedy.log_det - found.log_det;
  for (const std::uint32_t i : found.indices) outcome.differing += 1 - greedy.indices.count(i);
  const double sample = static_cast<double>(n) / static_cast<double>(k) * std::log(1 / epsilon);
  outcome.gains = gains_asked_for(n, k, static_cast<std::size_t>(std::ceil(sample)));
  outcome.gains_greedy = gains_asked_for(n, k, n);
  outcome.share_of_greedy = (found.log_det - log_det_prior) / (greedy.log_det - log_det_prior);
  return outcome;
}

}  // namespace

nlohmann::ordered_json to_json(const EpsilonOptions& options) {
  return {{"experiment", "epsilon"},
          {"seed", options.seed},
          {"sizes", options.sizes},
          {"shares", options.shares},
          {"epsilons", options.epsilons},
          {"scene", to_string(options.scene)},
          {"weighting", to_string(options.weighting)}};
}

std::vector<EpsilonOutcome> run_epsilon(const EpsilonOptions& options, std::size_t n, std::uint64_t run) {
  Draws seeds(options.seed, run);
  const Frame frame = make_scene(options.scene, n, seeds.bits());
  BlockOptions block_options;
  block_options.weighting = options.weighting;
  BlockStore blocks;
  build_blocks(frame, block_options, blocks);
  Selector selector(n);

  std::vector<EpsilonOutcome> outcomes;
  for (const double share : options.shares) {
    const auto k = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(share * static_cast<double>(n))));
    const Reference reference = reference_of(selector, blocks, k);
    for (const double epsilon : options.epsilons) {
      Options search = options_of(k, Strategy::stochastic_greedy);
      search.stochastic.epsilon = usable_epsilon(epsilon, n, k);
      search.stochastic.seed = seeds.bits();
      const Timed found = timed_select(selector, blocks, search);
      outcomes.push_back(outcome_of(n, k, search.stochastic.epsilon, found, reference));
      outcomes.back().epsilon = epsilon;
    }
  }
  return outcomes;
}

}  // namespace maxlogdet::sim
