// SPDX-License-Identifier: MIT
// Runs a million selections, valid and invalid, through a few selectors, half of them after mlockall: nothing may be
// allocated, memory may not grow, and every answer must be well-formed. Writes JSON, of which bench/run does_it_last
// makes a table. Usage: maxlogdet_soak [--selections N] [--seed S] [--output FILE]; exit code 1: a property does not
// hold, 2: bad arguments.
#include "bench/does_it_last/soak_judge.hpp"
#include "bench/does_it_last/soak_latency.hpp"
#include "bench/does_it_last/soak_requests.hpp"
#include "bench/world/progress.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/pool_executor.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

using Clock = std::chrono::steady_clock;

// Resident memory, KiB, from smaps_rollup, which is exact, while statm lags behind; -1 if it cannot be read.
long resident() {
  const int file = open("/proc/self/smaps_rollup", O_RDONLY | O_CLOEXEC);
  if (file < 0) return -1;
  char text[4096];
  const ssize_t length = read(file, text, sizeof text - 1);
  close(file);
  if (length <= 0) return -1;
  text[length] = '\0';
  const char* const found = std::strstr(text, "Rss:");
  return found == nullptr ? -1 : std::strtol(found + 4, nullptr, 10);
}

struct Faults {
  long minor;
  long major;
};

Faults faults_so_far() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return {usage.ru_minflt, usage.ru_majflt};
}

struct Phase {
  std::string name;
  std::size_t selections = 0;
  double seconds = 0;
  long allocations_in_select = 0;
  long allocations_in_filling = 0;
  long resident_at_tenth = 0;  // KiB
  long resident_at_end = 0;    // KiB
  Faults faults{};
  std::size_t malformed = 0;
  std::string first_malformed;
  LatencyHistogram ordinary;
  LatencyHistogram everything_else;
};

// How many well-formed answers had each status, and each error. Counting allocates nothing.
class Endings {
 public:
  void count(const Selection& selection) noexcept {
    ++(selection.has_answer() ? statuses_[static_cast<std::size_t>(selection.status)]
                              : errors_[static_cast<std::size_t>(selection.error)]);
  }

  template <class Body>
  void for_each(const Body& body) const {
    for (std::size_t i = 0; i < statuses_.size(); ++i) {
      if (statuses_[i] > 0) body(to_string(static_cast<Status>(i)), statuses_[i]);
    }
    for (std::size_t i = 0; i < errors_.size(); ++i) {
      if (errors_[i] > 0) body(to_string(static_cast<Error>(i)), errors_[i]);
    }
  }

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(Status::error)> statuses_{};
  std::array<std::uint64_t, static_cast<std::size_t>(Error::mixed_depth_cues) + 1> errors_{};
};

// Selectors that work alone, with a helper, and one that is too small for nearly all stores.
struct Selectors {
  test::PoolExecutor pool{1};
  Selector alone{SoakRequests::capacity};
  Selector helped{SoakRequests::capacity, &pool};
  Selector small{64};

  Selector& of(const SoakRequest& request, std::size_t number) noexcept {
    if (request.is_ordinary) return alone;
    if (request.options.threads > 1) return helped;
    return number % 32 == 0 ? small : alone;
  }
};

void warm_up(const SoakRequests& requests, Selectors& selectors) {
  for (const SoakRequest& request : requests.warm_up()) {
    for (Selector* const selector : {&selectors.alone, &selectors.helped}) {
      selector->select(*request.store, request.options);
    }
  }
  const long before = selectors.pool.helped();  // the helper's thread may allocate in its first calls
  for (int turn = 0; turn < 10000 && selectors.pool.helped() < before + 10; ++turn) {
    SoakRequest request = requests.warm_up().front();
    selectors.helped.select(*request.store, request.options);
  }
}

// Everything that lives as long as the soak.
class Soak {
 public:
  Soak(std::size_t selections, std::uint64_t seed) : requests_(seed), selections_(selections) {
    warm_up(requests_, selectors_);
  }

  void run(Phase& phase) {
    constexpr std::size_t progress_every = 1024;
    const auto start = Clock::now();
    const Faults faults_before = faults_so_far();
    for (std::size_t i = 0; i < phase.selections; ++i) {
      run_selection(phase, i);
      if (i % progress_every == 0) progress_.update(done_ + i, selections_);
      if (i == phase.selections / 10) phase.resident_at_tenth = resident();
    }
    const Faults faults = faults_so_far();
    phase.faults = {faults.minor - faults_before.minor, faults.major - faults_before.major};
    phase.resident_at_end = resident();
    phase.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    done_ += phase.selections;
  }

  const Endings& endings() const { return endings_; }

 private:
  void run_selection(Phase& phase, std::size_t i) {
    const long before_filling = test::allocations();
    const SoakRequest& request = requests_.next();
    Selector& selector = selectors_.of(request, i);
    const long before = test::allocations();
    const auto begin = Clock::now();
    const Selection selection = selector.select(*request.store, request.options);
    const auto end = Clock::now();
    phase.allocations_in_select += test::allocations() - before;
    phase.allocations_in_filling += before - before_filling;
    const double microseconds = std::chrono::duration<double, std::micro>(end - begin).count();
    (request.is_ordinary ? phase.ordinary : phase.everything_else).add(microseconds);
    const char* const fault = judge_.fault_of(request, selector.capacity(), selection);
    if (fault == nullptr) {
      endings_.count(selection);
    } else if (phase.malformed++ == 0) {
      phase.first_malformed = std::string(fault) + ", selection " + std::to_string(i) + ", " +
                              to_string(request.options.strategy) + ", " + selection.reason();
    }
  }

  SoakRequests requests_;
  Selectors selectors_;
  SoakJudge judge_;
  Endings endings_;
  std::size_t selections_;
  std::size_t done_ = 0;
  sim::Progress progress_{"soaking", "selection"};
};

nlohmann::ordered_json json_of(const char* name, const LatencyHistogram& latency) {
  nlohmann::ordered_json json{{"class", name},
                              {"calls", latency.calls()},
                              {"p50_us", latency.quantile(0.5)},
                              {"p99_us", latency.quantile(0.99)},
                              {"p999_us", latency.quantile(0.999)},
                              {"max_us", latency.max()}};
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  latency.for_each([&steps](double end, std::uint64_t calls) { steps.push_back({end, calls}); });
  json["histogram"] = steps;  // [upper end in us, calls]
  return json;
}

nlohmann::ordered_json json_of(const Phase& phase) {
  return {{"phase", phase.name},
          {"selections", phase.selections},
          {"seconds", phase.seconds},
          {"allocations_in_select", phase.allocations_in_select},
          {"allocations_in_filling", phase.allocations_in_filling},
          {"resident_kib_at_a_tenth", phase.resident_at_tenth},
          {"resident_kib_at_the_end", phase.resident_at_end},
          {"minor_faults", phase.faults.minor},
          {"major_faults", phase.faults.major},
          {"malformed", phase.malformed},
          {"latency", {json_of("ordinary frame", phase.ordinary), json_of("everything else", phase.everything_else)}}};
}

// Describes the property that does not hold, in one line; empty if all hold.
std::string complaint_about(const Phase& phase) {
  if (phase.malformed > 0) {
    return std::to_string(phase.malformed) + " malformed answers, the first: " + phase.first_malformed;
  }
  if (phase.allocations_in_select > 0) return std::to_string(phase.allocations_in_select) + " allocations in select()";
  if (phase.allocations_in_filling > 0) {
    return std::to_string(phase.allocations_in_filling) + " allocations while filling stores within their capacity";
  }
#if !defined(MAXLOGDET_HAS_SANITIZER)  // a sanitizer's own bookkeeping grows
  constexpr long max_growth = 64;      // KiB of resident memory, by stacks and by counters of the kernel
  if (phase.resident_at_tenth < 0) return "the growth of memory is unknown: /proc/self/smaps_rollup cannot be read";
  const long growth = phase.resident_at_end - phase.resident_at_tenth;
  if (growth > max_growth) return "resident memory grew by " + std::to_string(growth) + " KiB";
#endif
  return "";
}

// The results of the phases, and whether the second one could lock its memory.
struct Outcome {
  std::vector<Phase> phases = std::vector<Phase>(2);
  std::string mlockall = "permitted";  // or why not
  Endings endings;
};

Outcome run_phases(std::size_t selections, std::uint64_t seed) {
  Outcome outcome;
  outcome.phases[0].name = "without mlockall";
  outcome.phases[1].name = "with mlockall";
  outcome.phases[0].selections = selections / 2;
  outcome.phases[1].selections = selections - outcome.phases[0].selections;
  Soak soak(selections, seed);
  soak.run(outcome.phases[0]);
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    outcome.mlockall = std::strerror(errno);
    outcome.phases[1].name = "mlockall not permitted";
  }
  soak.run(outcome.phases[1]);
  outcome.endings = soak.endings();
  return outcome;
}

nlohmann::ordered_json json_of(const Outcome& outcome, std::size_t selections, std::uint64_t seed, double load_before) {
  nlohmann::ordered_json json{{"selections", selections},       {"seed", seed},
                              {"version", version()},           {"isa", active_isa()},
                              {"compiler", MAXLOGDET_COMPILER}, {"load_before", load_before},
                              {"mlockall", outcome.mlockall}};
  json["phases"] = {json_of(outcome.phases[0]), json_of(outcome.phases[1])};
  outcome.endings.for_each([&json](const char* name, std::uint64_t answers) { json["statuses"][name] = answers; });
  return json;
}

int soak(std::size_t selections, std::uint64_t seed, const std::string& output) {
  double load[3] = {};
  getloadavg(load, 3);
  if (test::allocations() < 0) {
    std::fputs("maxlogdet_soak: allocations cannot be counted in this build; use one without sanitizers\n", stderr);
    return 1;
  }
  const Outcome outcome = run_phases(selections, seed);
  const std::string text = json_of(outcome, selections, seed, load[0]).dump(1) + "\n";
  if (output.empty()) {
    std::cout << text << std::flush;
  } else if (std::ofstream file(output); !(file << text).flush()) {
    std::cerr << "maxlogdet_soak: cannot write " << output << "; --output names a file in a folder that exists\n";
    return 2;
  }
  for (const Phase& phase : outcome.phases) {
    const std::string complaint = complaint_about(phase);
    if (complaint.empty()) continue;
    std::cerr << "maxlogdet_soak: " << complaint << " (" << phase.name << ", --seed " << seed << ")\n";
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace maxlogdet::bench

int main(int argc, char** argv) {
  try {
    std::size_t selections = 1000000;
    std::uint64_t seed = 1;
    std::string output;
    CLI::App program(
        "Selects a million times; exit code 1 if memory is allocated or grows, or if an answer is malformed.");
    program.name("maxlogdet_soak");
    program.add_option("--selections", selections, "number of selections")
        ->check(CLI::Range(std::size_t{20}, std::size_t{1} << 40U));
    program.add_option("--seed", seed, "seed of the requests");
    program.add_option("--output", output, "file for the JSON; default: standard output");
    try {
      program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) return program.exit(error);
      std::cerr << "maxlogdet_soak: " << error.what() << " (see maxlogdet_soak --help)\n";
      return 2;
    }
    return maxlogdet::bench::soak(selections, seed, output);
  } catch (const std::exception& error) {
    std::cerr << "maxlogdet_soak: " << error.what() << '\n';
    return 1;
  }
}
