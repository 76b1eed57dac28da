// SPDX-License-Identifier: MIT
#include "bench/measure.hpp"

#include "sim/latency.hpp"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

namespace maxlogdet::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t fewest_calls = 3;  // in a repetition, however slow
constexpr double warm_up = 0.003;        // s

double repetition_seconds = 0.2;

std::size_t repeated_cases = 0;
std::size_t single_cases = 0;
std::size_t expected_runs = 0;  // 0: unknown

struct Samples {
  std::vector<double> microseconds;
  Sums sums;
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

void show_progress(const std::string& name) {
  static const auto start = Clock::now();
  static std::size_t runs = 0;
  const std::string of = expected_runs > 0 ? " of " + std::to_string(expected_runs) : "";
  const bool is_terminal = isatty(STDERR_FILENO) == 1;
  std::fprintf(stderr, "%srun %zu%s, %.0f s: %.90s%s", is_terminal ? "\r\033[K" : "", ++runs, of.c_str(),
               seconds_since(start), name.c_str(), is_terminal ? "" : "\n");
}

void run_repetition(const Work& work, std::size_t calls, Samples& samples) {
  const auto start_of_warm_up = Clock::now();
  do work.run(0);
  while (seconds_since(start_of_warm_up) < warm_up);

  const auto start_of_run = Clock::now();
  const auto is_done = [&](std::size_t call) {
    if (calls > 0) return call >= calls;
    return call >= fewest_calls && seconds_since(start_of_run) >= repetition_seconds;
  };
  const std::size_t first = samples.microseconds.size();  // stochastic strategies: seeds not used so far
  for (std::size_t call = 0; !is_done(call); ++call) {
    const auto start = Clock::now();
    work.run(first + call);
    samples.microseconds.push_back(1e6 * seconds_since(start));
    if (work.record) work.record(first + call, samples.sums);
  }
}

void measure(benchmark::State& state, const std::string& name, const std::function<Work()>& make_work,
             std::size_t calls, Samples& samples) {
  show_progress(name);
  for (auto iteration : state) {
    (void)iteration;
    run_repetition(make_work(), calls, samples);
    state.SetIterationTime(1e-6 * sim::latency_of(samples.microseconds).median);
  }
  const sim::Latency latency = sim::latency_of(samples.microseconds);
  state.counters["median_us"] = latency.median;
  state.counters["p99_us"] = latency.p99;
  state.counters["p999_us"] = latency.p999;
  state.counters["max_us"] = latency.max;
  const auto count = static_cast<double>(samples.microseconds.size());
  state.counters["calls"] = count;
  for (const auto& [counter, sum] : samples.sums) state.counters[counter] = sum / count;
}

}  // namespace

void add_case(const std::string& name, std::function<Work()> make_work, std::size_t calls) {
  const auto samples = std::make_shared<Samples>();
  auto* const registered = benchmark::RegisterBenchmark(
      name.c_str(), [name, make_work = std::move(make_work), calls, samples](benchmark::State& state) {
        measure(state, name, make_work, calls, *samples);
      });
  registered->UseManualTime()->Unit(benchmark::kMicrosecond)->Iterations(1);
  if (calls > 0) registered->Repetitions(1);
  ++(calls > 0 ? single_cases : repeated_cases);
}

void set_seconds_per_repetition(double seconds) { repetition_seconds = seconds; }

void run_cases(std::size_t repetitions, bool all) {
  if (all) expected_runs = single_cases + repetitions * repeated_cases;
  benchmark::RunSpecifiedBenchmarks();
  if (isatty(STDERR_FILENO) == 1) std::fputs("\r\033[K", stderr);
}

}  // namespace maxlogdet::bench
