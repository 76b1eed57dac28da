// SPDX-License-Identifier: MIT
// Measures, in frames of 2000 candidates with k = 100, how far stochastic greedy stays behind lazy greedy, and what the
// proved upper bound of the log det is worth and costs. Writes JSON; bench/how_good/write_pages.py makes sentences.
#include "bench/world/scene.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::bench {
namespace {

constexpr std::size_t n = 2000;
constexpr std::size_t k = 100;
constexpr std::uint64_t seeds = 100;
constexpr double epsilons[] = {0.5, 0.1, 0.01};

Options options_of(Strategy strategy) {
  Options options;
  options.strategy = strategy;
  options.budget = k;
  return options;
}

// What the certificate adds to the fastest call, us; the two kinds of calls take turns.
double microseconds_of_bound(Selector& selector, const BlockStore& store) {
  using Clock = std::chrono::steady_clock;
  Options options = options_of(Strategy::lazy_greedy);
  double fastest[2];
  std::fill(std::begin(fastest), std::end(fastest), std::numeric_limits<double>::infinity());
  for (int turn = 0; turn < 300; ++turn) {
    options.certificate = turn % 2 == 1;
    const auto start = Clock::now();
    selector.select(store, options);
    const std::chrono::duration<double, std::micro> time = Clock::now() - start;
    fastest[turn % 2] = std::min(fastest[turn % 2], time.count());
  }
  return fastest[1] - fastest[0];
}

double mean_loss(Selector& selector, const BlockStore& store, double epsilon, double greedy_log_det) {
  Options options = options_of(Strategy::stochastic_greedy);
  options.stochastic.epsilon = epsilon;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    options.stochastic.seed = seed;
    sum += greedy_log_det - selector.select(store, options).log_det;
  }
  return sum / static_cast<double>(seeds);
}

nlohmann::ordered_json measured(const BlockStore& store) {
  Selector selector(n);
  Options certified = options_of(Strategy::lazy_greedy);
  certified.certificate = true;
  const Selection selection = selector.select(store, certified);
  const double log_det = selection.log_det;
  nlohmann::ordered_json row = {{"gap_nats", selection.upper_bound - log_det},
                                {"bound_us", microseconds_of_bound(selector, store)}};
  for (const double epsilon : epsilons) {
    row["losses"].push_back({{"epsilon", epsilon}, {"mean_nats", mean_loss(selector, store, epsilon, log_det)}});
  }
  return row;
}

}  // namespace
}  // namespace maxlogdet::bench

int main() {  // NOLINT(bugprone-exception-escape): that ends the program
  using namespace maxlogdet;
  using bench::measured, bench::n;
  nlohmann::ordered_json rows;
  for (const sim::Scene scene : sim::scenes) {
    for (const DepthCue depth_cue : {DepthCue::none, DepthCue::stereo}) {
      for (const bool has_covariances : {false, true}) {
        sim::Frame frame = make_scene(scene, n, 1);
        if (has_covariances) frame.map_covariances.assign(n, {0.0025, 0, 0, 0, 0.0025, 0, 0, 0, 0.0025});  // 5 cm
        BlockStore store(n);
        build_blocks(frame, feature_matches(frame, depth_cue), BlockOptions(), store);
        rows.push_back(measured(store));
      }
    }
  }
  std::printf("%s\n", rows.dump(1).c_str());
  return 0;
}
