// SPDX-License-Identifier: MIT
// Usage: maxlogdet_bench [--full] [Google Benchmark options]; bench/how_fast/run calls it.
#include "bench/how_fast/cases.hpp"
#include "bench/how_fast/measure.hpp"

#include <benchmark/benchmark.h>
#include <maxlogdet/maxlogdet.hpp>

#include <string>
#include <vector>

int main(int argc, char** argv) {
  // Defaults, which arguments override. Benchmark's min_time does not apply: see measure.hpp.
  std::string repetitions = "--benchmark_repetitions=3";
  std::string interleaving = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> arguments = {argv[0], repetitions.data(), interleaving.data()};
  bool full = false;
  bool all = true;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto names = [&argument](const char* option) { return argument.rfind(option, 0) == 0; };
    full = full || argument == "--full";
    all = all && !names("--benchmark_filter") && !names("--benchmark_repetitions");
    if (argument != "--full") arguments.push_back(argv[i]);
  }
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::AddCustomContext("maxlogdet_version", maxlogdet::version());
  benchmark::AddCustomContext("maxlogdet_isa", maxlogdet::active_isa());
  benchmark::AddCustomContext("maxlogdet_compiler", MAXLOGDET_COMPILER " " MAXLOGDET_BUILD_TYPE);
  if (full) maxlogdet::bench::set_seconds_per_repetition(1);
  maxlogdet::bench::add_selection_cases(full);
  maxlogdet::bench::add_append_cases();
  maxlogdet::bench::add_threading_cases();
  maxlogdet::bench::add_tracker_cases();
  maxlogdet::bench::run_cases(3, all);
  return 0;
}
