// SPDX-License-Identifier: MIT
// Usage: maxlogdet_bench [Google Benchmark options]; bench/how_fast/run calls it.
#include "bench/how_fast/measure.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/latency.hpp"

#include <benchmark/benchmark.h>
#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

namespace maxlogdet::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t min_cycles = 3;       // over the inputs, however slow the work is
constexpr double seconds_per_block = 0.02;  // of hot calls; cold ones take min_cycles

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Walks over 8 MiB and sorts 60 000 random numbers.
class Disturbance {
 public:
  void operator()() {
    constexpr std::size_t cache_line = 64;
    for (std::size_t i = 0; i < memory_.size(); i += cache_line) ++memory_[i];
    for (int& number : numbers_) number = static_cast<int>(random_.bits() >> 33U);
    std::sort(numbers_.begin(), numbers_.end());
    benchmark::DoNotOptimize(memory_.data());
    benchmark::DoNotOptimize(numbers_.data());
    benchmark::ClobberMemory();
  }

 private:
  std::vector<unsigned char> memory_ = std::vector<unsigned char>(std::size_t{8} << 20U);
  std::vector<int> numbers_ = std::vector<int>(60000);
  sim::Draws random_{1};
};

// Of all blocks of a case.
struct Samples {
  std::vector<double> times;  // us
  Sums sums;
};

// Returns the time of a block, us.
double run_block(const Work& work, Caches caches, Samples& samples) {
  static Disturbance disturb;
  const std::size_t first = samples.times.size();  // so that each block has new seeds
  std::vector<double> fastest(work.inputs, std::numeric_limits<double>::infinity());
  const auto start_of_block = Clock::now();
  const auto is_done = [&](std::size_t cycle) {
    return cycle > min_cycles && (caches == Caches::cold || seconds_since(start_of_block) > seconds_per_block);
  };
  for (std::size_t cycle = 0; !is_done(cycle); ++cycle) {
    for (std::size_t input = 0; input < work.inputs; ++input) {
      const std::size_t call = first + cycle * work.inputs + input;
      if (work.prepare) work.prepare(call);
      if (caches == Caches::cold) disturb();
      const auto start = Clock::now();
      work.run(call);  // all that is timed
      const double microseconds = 1e6 * seconds_since(start);
      if (cycle == 0) continue;  // warms up
      fastest[input] = std::min(fastest[input], microseconds);
      samples.times.push_back(microseconds);
      if (work.record) work.record(call, samples.sums);
    }
  }
  return std::accumulate(fastest.begin(), fastest.end(), 0.0) / static_cast<double>(work.inputs);
}

}  // namespace

void add_case(const std::string& name, const std::function<Work()>& make_work, Caches caches, int blocks) {
  const auto samples = std::make_shared<Samples>();
  auto* const added = benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    for (auto iteration : state) {
      (void)iteration;
      state.SetIterationTime(1e-6 * run_block(make_work(), caches, *samples));
    }
    const auto count = static_cast<double>(samples->times.size());  // so far
    state.counters["calls"] = count;
    state.counters["p99_us"] = sim::latency_of(samples->times).p99;
    for (const auto& [counter, sum] : samples->sums) state.counters[counter] = sum / count;
  });
  added->UseManualTime()->Unit(benchmark::kMicrosecond)->Iterations(1);
  if (blocks > 0) added->Repetitions(blocks);
}

}  // namespace maxlogdet::bench

int main(int argc, char** argv) {
  // Defaults, which arguments override.
  std::string repetitions = "--benchmark_repetitions=20";
  std::string interleaving = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> arguments = {argv[0], repetitions.data(), interleaving.data()};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::AddCustomContext("maxlogdet_isa", maxlogdet::active_isa());
  maxlogdet::bench::add_selection_cases();
  maxlogdet::bench::add_tracker_cases();
  return benchmark::RunSpecifiedBenchmarks() > 0 ? 0 : 1;
}
