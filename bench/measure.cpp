// SPDX-License-Identifier: MIT
#include "bench/measure.hpp"

#include "sim/latency.hpp"

#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
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
  std::vector<double> undisturbed;  // those of calls that were not preempted
  Sums sums;
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// How often another process got this one's processor.
long preemptions_so_far() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_nivcsw;
}

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
    const long preemptions_before = preemptions_so_far();
    const auto start = Clock::now();
    work.run(first + call);
    const double microseconds = 1e6 * seconds_since(start);
    const long preemptions = preemptions_so_far() - preemptions_before;
    samples.microseconds.push_back(microseconds);
    if (preemptions == 0) samples.undisturbed.push_back(microseconds);
    samples.sums["preemptions"] += static_cast<double>(preemptions);
    if (work.record) work.record(first + call, samples.sums);
  }
}

class Case : public benchmark::internal::Benchmark {
 public:
  Case(const std::string& name, std::function<Work()> make_work, std::size_t calls)
      : Benchmark(name.c_str()), name_(name), make_work_(std::move(make_work)), calls_(calls) {
    UseManualTime()->Unit(benchmark::kMicrosecond)->Iterations(1);
    if (calls > 0) Repetitions(1);
  }

  void Run(benchmark::State& state) override {
    show_progress(name_);
    for (auto iteration : state) {
      (void)iteration;
      run_repetition(make_work_(), calls_, samples_);
      state.SetIterationTime(1e-6 * sim::latency_of(samples_.microseconds).median);
    }
    const sim::Latency latency = sim::latency_of(samples_.microseconds);
    state.counters["median_us"] = latency.median;
    state.counters["min_us"] = *std::min_element(samples_.microseconds.begin(), samples_.microseconds.end());
    state.counters["p99_us"] = latency.p99;
    state.counters["p999_us"] = latency.p999;
    state.counters["max_us"] = latency.max;
    if (!samples_.undisturbed.empty()) {
      state.counters["undisturbed_p99_us"] = sim::latency_of(samples_.undisturbed).p99;
    }
    const auto count = static_cast<double>(samples_.microseconds.size());
    state.counters["calls"] = count;
    for (const auto& [counter, sum] : samples_.sums) state.counters[counter] = sum / count;
  }

 private:
  std::string name_;
  std::function<Work()> make_work_;
  std::size_t calls_;  // 0: as many as fit
  Samples samples_;    // of all repetitions so far
};

}  // namespace

void add_case(const std::string& name, std::function<Work()> make_work, std::size_t calls) {
  auto* const added = new Case(name, std::move(make_work), calls);  // Google Benchmark takes it over
  benchmark::internal::RegisterBenchmarkInternal(added);            // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks)
  ++(calls > 0 ? single_cases : repeated_cases);
}

void set_seconds_per_repetition(double seconds) { repetition_seconds = seconds; }

void run_cases(std::size_t repetitions, bool all) {
  if (all) expected_runs = single_cases + repetitions * repeated_cases;
  benchmark::RunSpecifiedBenchmarks();
  if (isatty(STDERR_FILENO) == 1) std::fputs("\r\033[K", stderr);
}

}  // namespace maxlogdet::bench
