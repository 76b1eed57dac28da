// SPDX-License-Identifier: MIT
#include "bench/how_fast/measure.hpp"

#include "bench/world/latency.hpp"

#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <regex>
#include <utility>
#include <vector>

namespace maxlogdet::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t min_calls = 3;  // of a repetition, however slow the work is
constexpr double warm_up = 0.003;     // s

double repetition_seconds = 0.2;

std::size_t repeated_cases = 0;
std::size_t single_cases = 0;
std::size_t expected_runs = 0;  // 0: unknown

struct Samples {
  std::vector<double> microseconds;
  std::vector<double> undisturbed;  // microseconds of the calls that were not preempted
  Sums sums;
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// How often the scheduler took the processor from this process.
long preemptions_so_far() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_nivcsw;
}

void show(const std::string& text) {
  const bool is_terminal = isatty(STDERR_FILENO) == 1;
  std::fprintf(stderr, "%s%.120s%s", is_terminal ? "\r\033[K" : "", text.c_str(), is_terminal ? "" : "\n");
}

void show_progress(const std::string& name) {
  static const auto start = Clock::now();
  static std::size_t runs = 0;
  const std::string of = expected_runs > 0 ? " of " + std::to_string(expected_runs) : "";
  show("run " + std::to_string(++runs) + of + ", " + std::to_string(std::lround(seconds_since(start))) + " s: " + name);
}

// Times one call, and records its counters.
void time_call(const Work& work, std::size_t call, Samples& samples) {
  const long preemptions_before = preemptions_so_far();
  const auto start = Clock::now();
  work.run(call);
  const double microseconds = 1e6 * seconds_since(start);
  const long preemptions = preemptions_so_far() - preemptions_before;
  samples.microseconds.push_back(microseconds);
  if (preemptions == 0) samples.undisturbed.push_back(microseconds);
  samples.sums["preemptions"] += static_cast<double>(preemptions);
  if (work.record) work.record(call, samples.sums);
}

void run_repetition(const Work& work, std::size_t calls, Samples& samples) {
  const auto start_of_warm_up = Clock::now();
  do work.run(0);
  while (seconds_since(start_of_warm_up) < warm_up);

  const auto start_of_run = Clock::now();
  const auto is_done = [&](std::size_t call) {
    if (calls > 0) return call >= calls;
    return call >= min_calls && seconds_since(start_of_run) >= repetition_seconds;
  };
  const std::size_t first = samples.microseconds.size();  // new seeds for the stochastic strategies
  for (std::size_t call = 0; !is_done(call); ++call) time_call(work, first + call, samples);
}

void report(const Samples& samples, benchmark::State& state) {
  const sim::Latency latency = sim::latency_of(samples.microseconds);
  state.counters["median_us"] = latency.median;
  state.counters["min_us"] = *std::min_element(samples.microseconds.begin(), samples.microseconds.end());
  state.counters["p99_us"] = latency.p99;
  state.counters["p999_us"] = latency.p999;
  state.counters["max_us"] = latency.max;
  if (!samples.undisturbed.empty()) {
    state.counters["undisturbed_p99_us"] = sim::latency_of(samples.undisturbed).p99;
  }
  const auto count = static_cast<double>(samples.microseconds.size());
  state.counters["calls"] = count;
  for (const auto& [counter, sum] : samples.sums) state.counters[counter] = sum / count;
}

// Every case is one iteration of Google Benchmark, which calls `measure` to add to the samples.
class Case : public benchmark::internal::Benchmark {
 public:
  Case(const std::string& name, bool is_repeated, std::function<const Samples&()> measure)
      : Benchmark(name.c_str()), name_(name), measure_(std::move(measure)) {
    UseManualTime()->Unit(benchmark::kMicrosecond)->Iterations(1);
    if (!is_repeated) Repetitions(1);
    ++(is_repeated ? repeated_cases : single_cases);
  }

  void Run(benchmark::State& state) override {
    show_progress(name_);
    for (auto iteration : state) {
      (void)iteration;
      const Samples& samples = measure_();
      if (samples.microseconds.empty())
        return state.SkipWithError("the filter excluded this case when its group was measured");
      state.SetIterationTime(1e-6 * sim::latency_of(samples.microseconds).median);
      report(samples, state);
    }
  }

 private:
  std::string name_;
  std::function<const Samples&()> measure_;
};

void add(const std::string& name, bool is_repeated, std::function<const Samples&()> measure) {
  auto* const added = new Case(name, is_repeated, std::move(measure));  // Google Benchmark owns it
  benchmark::internal::RegisterBenchmarkInternal(added);  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks)
}

// Whether the filter runs a group's case of this name. With a negative filter, which begins with a minus, all cases
// count as run.
bool passes_filter(const std::string& name) {
  const std::string filter = benchmark::GetBenchmarkFilter();
  if (filter.empty() || filter == "all" || filter.front() == '-') return true;
  return std::regex_search(name + "/iterations:1/repeats:1/manual_time", std::regex(filter, std::regex::extended));
}

}  // namespace

struct Group::State {
  struct Member {
    std::string name;
    std::function<Work()> make_work;
    Samples samples;
  };

  static void prepare_and_run(const Work& work, std::size_t call) {
    if (work.prepare) work.prepare(call);
    work.run(call);
  }

  // Measures once, when Google Benchmark runs the first member.
  void measure() {
    if (is_measured) return;
    is_measured = true;
    std::vector<std::pair<Member*, Work>> works;
    for (Member& member : members) {
      if (!passes_filter(member.name)) continue;
      works.emplace_back(&member, member.make_work());
      prepare_and_run(works.back().second, 0);
    }
    const double seconds = turns.seconds_per_case * static_cast<double>(works.size());
    show(name + ": " + std::to_string(works.size()) + " cases, interleaved, for " +
         std::to_string(std::lround(seconds)) + " s");
    std::size_t call = 0;  // the same number for all members, as it is their seed
    const auto start = Clock::now();
    do {
      for (auto& [member, work] : works) {
        for (std::size_t i = 0; i < turns.untimed; ++i) prepare_and_run(work, call + i);
        for (std::size_t i = turns.untimed; i < turns.untimed + turns.timed; ++i) {
          if (work.prepare) work.prepare(call + i);
          if (turns.disturb) turns.disturb();
          time_call(work, call + i, member->samples);
        }
      }
      call += turns.untimed + turns.timed;
    } while (seconds_since(start) < seconds);
  }

  std::string name;
  Turns turns;
  std::deque<Member> members{};  // a deque keeps references to its elements valid
  bool is_measured = false;
};

Group::Group(const std::string& name, const Turns& turns) : state_(std::make_shared<State>(State{name, turns})) {}

void Group::add(const std::string& name, std::function<Work()> make_work) {
  state_->members.push_back({name, std::move(make_work), {}});
  const Samples& samples = state_->members.back().samples;
  bench::add(name, false, [state = state_, &samples]() -> const Samples& {
    state->measure();
    return samples;
  });
}

void add_case(const std::string& name, std::function<Work()> make_work, std::size_t calls) {
  const auto samples = std::make_shared<Samples>();  // of all repetitions so far
  add(name, calls == 0, [make_work = std::move(make_work), calls, samples]() -> const Samples& {
    run_repetition(make_work(), calls, *samples);
    return *samples;
  });
}

void set_seconds_per_repetition(double seconds) { repetition_seconds = seconds; }

void run_cases(std::size_t repetitions, bool all) {
  if (all) expected_runs = single_cases + repetitions * repeated_cases;
  benchmark::RunSpecifiedBenchmarks();
  if (isatty(STDERR_FILENO) == 1) std::fputs("\r\033[K", stderr);
}

}  // namespace maxlogdet::bench
