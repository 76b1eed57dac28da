// SPDX-License-Identifier: MIT
// A million selections, valid and not, through a few selectors that live as long: nothing may be allocated, grow or be
// malformed. Half of them before, half after mlockall. Writes what it found as JSON; bench/soak makes a table of it.
// Usage: maxlogdet_soak [--selections N] [--seed S] [--output FILE]; exit code 1: it does not hold, 2: bad arguments.
#include "bench/soak_latency.hpp"
#include "bench/soak_requests.hpp"
#include "sim/progress.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/pool_executor.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
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

// Resident memory, KiB; exact, unlike statm, which lags behind. -1: the kernel does not tell.
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

// What is wrong with an answer; nullptr: nothing.
class Judge {
 public:
  const char* fault_of(const SoakRequest& request, std::size_t capacity, const Selection& selection) noexcept {
    const Options& options = request.options;
    if (std::strcmp(to_string(selection.status), "unknown") == 0) return "a status without a name";
    if (!selection.has_answer()) {
      const bool is_empty = selection.size == 0 && std::isnan(selection.log_det) && std::isnan(selection.upper_bound);
      if (!is_empty) return "an error with an answer";
      return request.must_fail || may_refuse(request, capacity, selection.status) ? nullptr
                                                                                  : "a refusal without reason";
    }
    if (request.must_fail) return "an answer to an invalid request";
    if (selection.size > options.budget) return "more than the budget";
    if (selection.status == Status::ok && selection.size < options.budget) return "fewer than the budget";
    if (selection.status == Status::deadline_reached && options.time_limit == 0) return "a deadline that nobody set";
    if (selection.status == Status::all_selected && !options.excluded && !options.groups &&
        selection.size != request.store->size() - request.store->invalid_count()) {
      return "not all, though it says so";
    }
    if (!std::isfinite(selection.log_det)) return "a log det that is not finite";
    if (options.certify ? !(selection.upper_bound >= selection.log_det) : !std::isnan(selection.upper_bound)) {
      return "a bound below the answer, or one not asked for";
    }
    return fault_of_indices(*request.store, options, selection);
  }

 private:
  // What a request that breaks no rule may be refused for.
  static bool may_refuse(const SoakRequest& request, std::size_t capacity, Status status) noexcept {
    switch (status) {
      case Status::infeasible: return request.options.required != nullptr;
      case Status::unsupported_groups: return request.options.groups != nullptr;
      case Status::capacity_exceeded: return request.store->size() > capacity;
      case Status::invalid_budget: return request.options.budget > capacity;
      default: return false;
    }
  }

  const char* fault_of_indices(const BlockStore& store, const Options& options, const Selection& selection) noexcept {
    ++now_;
    if (options.groups != nullptr) std::fill_n(of_group_.begin(), options.group_count, 0U);
    for (std::size_t i = 0; i < selection.size; ++i) {
      const std::uint32_t index = selection.indices[i];
      if (index >= store.size()) return "an index that does not exist";
      if (seen_[index] == now_) return "an index twice";
      seen_[index] = now_;
      if (!store.is_valid(index)) return "an invalid candidate";
      if (options.excluded != nullptr && options.excluded[index] != 0) return "an excluded candidate";
      if (!(selection.gains[i] >= 0) || !std::isfinite(selection.gains[i])) return "a gain that is not one";
      if (options.groups != nullptr) {
        const std::uint32_t group = options.groups[index];
        const std::size_t most = options.group_maxima == nullptr ? options.max_per_group : options.group_maxima[group];
        if (++of_group_[group] > most) return "too many of a group";
      }
    }
    for (std::size_t i = 0; options.required != nullptr && i < store.size(); ++i) {
      if (options.required[i] != 0 && seen_[i] != now_) return "without a required candidate";
    }
    return nullptr;
  }

  std::array<std::uint64_t, SoakRequests::capacity> seen_{};  // in which answer last, by index
  std::array<std::uint32_t, SoakRequests::capacity> of_group_{};
  std::uint64_t now_ = 0;
};

// Selectors that live as long as the soak: alone, with helpers, and one that is too small for most stores.
struct Selectors {
  sim::PoolExecutor pool{1};
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
  const long before = selectors.pool.helped();  // its thread may allocate when it first does something
  for (int turn = 0; turn < 10000 && selectors.pool.helped() < before + 10; ++turn) {
    SoakRequest request = requests.warm_up().front();
    selectors.helped.select(*request.store, request.options);
  }
}

void run(Phase& phase, SoakRequests& requests, Selectors& selectors, Judge& judge, std::uint64_t* statuses,
         sim::Progress& progress, std::size_t done, std::size_t all) {
  constexpr std::size_t progress_every = 1024;
  const auto start = Clock::now();
  const Faults faults_before = faults_so_far();
  for (std::size_t i = 0; i < phase.selections; ++i) {
    const long before_filling = sim::allocations();
    const SoakRequest& request = requests.next();
    Selector& selector = selectors.of(request, i);
    const long before = sim::allocations();
    const auto begin = Clock::now();
    const Selection selection = selector.select(*request.store, request.options);
    const auto end = Clock::now();
    phase.allocations_in_select += sim::allocations() - before;
    phase.allocations_in_filling += before - before_filling;
    const double microseconds = std::chrono::duration<double, std::micro>(end - begin).count();
    (request.is_ordinary ? phase.ordinary : phase.everything_else).add(microseconds);
    const char* const fault = judge.fault_of(request, selector.capacity(), selection);
    if (fault == nullptr) {
      ++statuses[static_cast<std::size_t>(selection.status)];
    } else if (phase.malformed++ == 0) {
      phase.first_malformed = std::string(fault) + ", selection " + std::to_string(i) + ", " +
                              to_string(selection.strategy) + ", " + to_string(selection.status);
    }
    if (i % progress_every == 0) progress.update(done + i, all);
    if (i == phase.selections / 10) phase.resident_at_tenth = resident();
  }
  const Faults faults = faults_so_far();
  phase.faults = {faults.minor - faults_before.minor, faults.major - faults_before.major};
  phase.resident_at_end = resident();
  phase.seconds = std::chrono::duration<double>(Clock::now() - start).count();
}

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

// What does not hold, in one line; empty: all does.
std::string complaint_about(const Phase& phase) {
  if (phase.malformed > 0) {
    return std::to_string(phase.malformed) + " malformed answers, the first: " + phase.first_malformed;
  }
  if (phase.allocations_in_select > 0) return std::to_string(phase.allocations_in_select) + " allocations in select()";
  if (phase.allocations_in_filling > 0) {
    return std::to_string(phase.allocations_in_filling) + " allocations in filling stores within their capacity";
  }
#if !defined(MAXLOGDET_HAS_SANITIZER)  // its own bookkeeping grows
  constexpr long max_growth = 64;      // KiB of resident memory, by stacks and counters of the kernel
  if (phase.resident_at_tenth < 0) return "/proc/self/smaps_rollup cannot be read, so nothing is known of its growth";
  const long growth = phase.resident_at_end - phase.resident_at_tenth;
  if (growth > max_growth) return "resident memory grew by " + std::to_string(growth) + " KiB";
#endif
  return "";
}

int soak(std::size_t selections, std::uint64_t seed, const std::string& output) {
  constexpr std::size_t status_count = static_cast<std::size_t>(Status::unsupported_target) + 1;
  double load[3] = {};
  getloadavg(load, 3);
  if (sim::allocations() < 0) {
    std::fputs("maxlogdet_soak: allocations cannot be counted in this build; use one without sanitizers\n", stderr);
    return 1;
  }
  SoakRequests requests(seed);
  Selectors selectors;
  Judge judge;
  std::vector<std::uint64_t> statuses(status_count);
  warm_up(requests, selectors);

  std::vector<Phase> phases(2);
  phases[0].name = "without mlockall";
  phases[1].name = "with mlockall";
  phases[0].selections = selections / 2;
  phases[1].selections = selections - phases[0].selections;
  std::string mlockall_says = "permitted";
  {
    sim::Progress progress("soaking", "selection");
    run(phases[0], requests, selectors, judge, statuses.data(), progress, 0, selections);
    if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
      mlockall_says = std::strerror(errno);
      phases[1].name = "mlockall not permitted";
    }
    run(phases[1], requests, selectors, judge, statuses.data(), progress, phases[0].selections, selections);
  }

  nlohmann::ordered_json json{
      {"selections", selections},       {"seed", seed},           {"version", version()},     {"isa", active_isa()},
      {"compiler", MAXLOGDET_COMPILER}, {"load_before", load[0]}, {"mlockall", mlockall_says}};
  json["phases"] = {json_of(phases[0]), json_of(phases[1])};
  for (std::size_t i = 0; i < status_count; ++i) {
    if (statuses[i] > 0) json["statuses"][to_string(static_cast<Status>(i))] = statuses[i];
  }
  const std::string text = json.dump(1) + "\n";
  if (output.empty()) {
    std::cout << text << std::flush;
  } else if (std::ofstream file(output); !(file << text).flush()) {
    std::cerr << "maxlogdet_soak: cannot write " << output << "; --output names a file in a folder that exists\n";
    return 2;
  }
  for (const Phase& phase : phases) {
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
    CLI::App program("Selects a million times; exit code 1 if anything is allocated, grows or is malformed.");
    program.name("maxlogdet_soak");
    program.add_option("--selections", selections, "how many")
        ->check(CLI::Range(std::size_t{20}, std::size_t{1} << 40U));
    program.add_option("--seed", seed, "of what is asked for");
    program.add_option("--output", output, "file for the JSON; without it, standard output");
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
