// SPDX-License-Identifier: MIT
// Latency of select() from a filled store, each call timed by itself, with the quality of its answer beside it.
#include "sim/latency.hpp"
#include "sim/scene.hpp"

#include <benchmark/benchmark.h>
#include <maxlogdet/maxlogdet.hpp>

#include <chrono>
#include <utility>
#include <vector>

namespace {

using maxlogdet::Strategy;

constexpr std::uint64_t scene_seed = 1;

// 2-row blocks, and two kinds of 3-row blocks.
enum Blocks { map_bias, map_bias_stereo, measurement_stereo };

maxlogdet::BlockStore make_blocks(std::size_t n, Blocks kind) {
  maxlogdet::BlockOptions options;
  if (kind == measurement_stereo) options.weighting = maxlogdet::Weighting::measurement;
  if (kind != map_bias) options.third = maxlogdet::ThirdMeasurement::stereo;
  maxlogdet::BlockStore blocks(n);
  build_blocks(make_scene(maxlogdet::sim::Scene::euroc_like, n, scene_seed), options, blocks);
  return blocks;
}

void select(benchmark::State& state, Strategy strategy, double epsilon) {
  const auto n = static_cast<std::size_t>(state.range(0));
  const maxlogdet::BlockStore blocks = make_blocks(n, static_cast<Blocks>(state.range(2)));
  maxlogdet::Selector selector(n);
  maxlogdet::Options options;
  options.budget = static_cast<std::size_t>(state.range(1));
  const double exact = selector.select(blocks, options).log_det;
  options.strategy = strategy;
  options.epsilon = epsilon;

  std::vector<double> microseconds;
  double log_det = 0;
  std::size_t evaluations = 0;
  for (auto iteration : state) {
    (void)iteration;
    const auto start = std::chrono::steady_clock::now();
    const maxlogdet::Selection selection = selector.select(blocks, options);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(elapsed.count());
    microseconds.push_back(1e6 * elapsed.count());
    log_det += selection.log_det;
    evaluations += selection.evaluations;
    ++options.seed;  // stochastic_greedy: the mean over samples
  }
  const auto calls = static_cast<double>(microseconds.size());
  const maxlogdet::sim::Latency latency = maxlogdet::sim::latency_of(std::move(microseconds));
  state.counters["median_us"] = latency.median;
  state.counters["p99_us"] = latency.p99;
  state.counters["max_us"] = latency.max;
  state.counters["delta_nats"] = log_det / calls - exact;
  state.counters["evaluations"] = static_cast<double>(evaluations) / calls;
}

void grid(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"n", "k", "blocks"})->UseManualTime()->Unit(benchmark::kMicrosecond);
  for (const int n : {200, 500, 1000, 2000, 5000}) {
    for (const int k : {60, 100}) {
      for (const Blocks blocks : {map_bias, map_bias_stereo, measurement_stereo}) benchmark->Args({n, k, blocks});
    }
  }
}

BENCHMARK_CAPTURE(select, greedy, Strategy::greedy, 0.1)->Apply(grid);
BENCHMARK_CAPTURE(select, lazy_greedy, Strategy::lazy_greedy, 0.1)->Apply(grid);
BENCHMARK_CAPTURE(select, stochastic_greedy_0p5, Strategy::stochastic_greedy, 0.5)->Apply(grid);
BENCHMARK_CAPTURE(select, stochastic_greedy_0p1, Strategy::stochastic_greedy, 0.1)->Apply(grid);
BENCHMARK_CAPTURE(select, stochastic_greedy_0p01, Strategy::stochastic_greedy, 0.01)->Apply(grid);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::AddCustomContext("maxlogdet_version", maxlogdet::version());
  benchmark::AddCustomContext("maxlogdet_isa", maxlogdet::active_isa());
  benchmark::AddCustomContext("maxlogdet_compiler", MAXLOGDET_COMPILER " " MAXLOGDET_BUILD_TYPE);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
