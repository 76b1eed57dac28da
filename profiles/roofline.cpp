// SPDX-License-Identifier: MIT
// Compares the evaluation of a full round with the limits of this core: its peak of float32 fused multiply-adds, and
// the bandwidth of its caches. All measurements take turns in short pieces, so that a transient load slows all of them
// down. Usage: roofline MACHINE COMMAND OUTPUT.json
#include "bench/world/latency.hpp"
#include "bench/world/statistics.hpp"
#include "profiles/core.hpp"
#include "profiles/full_round.hpp"
#include "simd/isas.hpp"

#include <unistd.h>
#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::profiles {

#define MAXLOGDET_DECLARE(name, is_there) extern const Core name##_core;
MAXLOGDET_ISAS(MAXLOGDET_DECLARE)
#undef MAXLOGDET_DECLARE

namespace {

#define MAXLOGDET_ADDRESS(name, is_there) &name##_core,
const Core* const cores[] = {MAXLOGDET_ISAS(MAXLOGDET_ADDRESS)};
#undef MAXLOGDET_ADDRESS

constexpr std::size_t turns = 2000;
constexpr double piece_seconds = 30e-6;  // longer than reading the clock takes, shorter than a time slice

using Clock = std::chrono::steady_clock;

double seconds_of(const std::function<void()>& work, std::size_t times) {
  const auto start = Clock::now();
  for (std::size_t i = 0; i < times; ++i) work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A piece of work that does `amount` of something in each call.
class Measurement {
 public:
  Measurement(double amount, std::function<void()> work) : amount_(amount), work_(std::move(work)) {
    while (seconds_of(work_, times_) < piece_seconds) times_ *= 2;
  }

  void take_turn() {
    work_();  // fills the caches with its own data again
    rates_.push_back(amount_ * static_cast<double>(times_) / seconds_of(work_, times_));
  }

  double highest() const { return *std::max_element(rates_.begin(), rates_.end()); }
  double median() const { return sim::quantile_of(rates_, 0.5); }

 private:
  double amount_;
  std::function<void()> work_;
  std::size_t times_ = 1;
  std::vector<double> rates_;  // of `amount` per second
};

volatile float sink = 0;  // keeps the compiler from dropping the work

// Of flops.
Measurement peak_of(const Core* core) {
  constexpr std::size_t steps = 1000;
  return {2.0 * steps * core->chains * core->lanes, [core] { sink = core->multiply_add(steps, 0.5f, 1.0f); }};
}

// Of bytes loaded from an array of this size.
Measurement loads_of(const Core* core, std::size_t bytes) {
  constexpr std::size_t passes = 8;
  const std::size_t count = bytes / sizeof(float) / sum_block * sum_block;
  auto memory = std::make_shared<std::vector<float>>(count + 16, 1.0f);
  void* aligned = memory->data();
  std::size_t space = memory->size() * sizeof(float);
  std::align(64, count * sizeof(float), aligned, space);
  return {static_cast<double>(passes * count * sizeof(float)),
          [memory, aligned, count, core] { sink = core->sum(static_cast<const float*>(aligned), count, passes); }};
}

// A full round, in gains.
struct Evaluation {
  const Core* core;
  int rows;
  Measurement rounds;
};

std::vector<Evaluation> evaluations_on(const std::vector<const Core*>& supported) {
  std::vector<Evaluation> evaluations;
  for (const int rows : {2, 3}) {
    for (const Core* core : supported) {
      const auto round = std::make_shared<FullRound>(core->isa, rows);
      evaluations.push_back({core, rows, Measurement(FullRound::candidates, [round] { (*round)(); })});
    }
  }
  return evaluations;
}

// As the operating system reports it, or a common size.
std::size_t cache_bytes(int name, std::size_t common) {
  const long reported = sysconf(name);
  return reported > 0 ? static_cast<std::size_t>(reported) : common;
}
std::size_t l1_bytes() { return cache_bytes(_SC_LEVEL1_DCACHE_SIZE, 32768); }
std::size_t l2_bytes() { return cache_bytes(_SC_LEVEL2_CACHE_SIZE, 524288); }

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[11] = "";
  if (gmtime_r(&now, &utc) != nullptr) std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

std::vector<const Core*> supported_cores() {
  std::vector<const Core*> supported;
  for (const Core* core : cores) {
    if (isa_is_supported(core->isa)) supported.push_back(core);
  }
  return supported;
}

// `roofs`: the peaks and the loads.
nlohmann::ordered_json json_of(const Evaluation& evaluation, const nlohmann::ordered_json& roofs) {
  const Core& core = *evaluation.core;
  const Arithmetic& arithmetic = gain_arithmetic[evaluation.rows - 1];
  const double peak = roofs["peak_gflops"][core.isa].get<double>();
  const double gflops = evaluation.rounds.highest() * arithmetic.flops / 1e9;
  // Vector instructions per second: those that the gains take, and those that the core executes at its peak.
  const double lanes = static_cast<double>(core.lanes) * sizeof(float) / element_bytes;
  const double slots = 1e9 * peak / (2.0 * core.lanes) * core.instructions_per_fma;
  const int operations = core.instructions_per_fma == 1 ? arithmetic.vector_operations : arithmetic.flops;
  const std::size_t bytes = FullRound::bytes_per_gain(evaluation.rows);
  const double intensity = static_cast<double>(arithmetic.flops) / static_cast<double>(bytes);
  const bool in_l1 = FullRound::candidates * bytes <= l1_bytes();
  const double memory_roof = intensity * roofs[in_l1 ? "l1_gb_s" : "l2_gb_s"].get<double>();
  const char* const memory_name = in_l1 ? "L1" : "L2";
  return {
      {"rows", evaluation.rows},
      {"isa", core.isa},
      {"gflops", gflops},
      {"gflops_median", evaluation.rounds.median() * arithmetic.flops / 1e9},
      {"ns_per_gain", 1e9 / evaluation.rounds.highest()},
      {"share_of_peak", gflops / peak},
      {"share_of_slots", evaluation.rounds.highest() * operations / lanes / slots},
      {"intensity", intensity},
      {"roof_gflops", std::min(peak, memory_roof)},
      {"roof", peak <= memory_roof ? "arithmetic" : memory_name},
  };
}

nlohmann::ordered_json measure() {
  const std::vector<const Core*> supported = supported_cores();
  const Core* const widest = supported.back();
  const std::size_t l1_array = l1_bytes() / 2;
  const std::size_t l2_array = l2_bytes() / 4;
  std::vector<Measurement> peaks;
  for (const Core* core : supported) peaks.push_back(peak_of(core));
  Measurement l1 = loads_of(widest, l1_array);
  Measurement l2 = loads_of(widest, l2_array);
  std::vector<Evaluation> evaluations = evaluations_on(supported);
  sim::measure_latency("measuring", turns, [&] {
    for (Measurement& peak : peaks) peak.take_turn();
    l1.take_turn();
    l2.take_turn();
    for (Evaluation& evaluation : evaluations) evaluation.rounds.take_turn();
  });

  nlohmann::ordered_json result;
  for (std::size_t i = 0; i < supported.size(); ++i) {
    result["peak_gflops"][supported[i]->isa] = peaks[i].highest() / 1e9;
    result["peak_gflops_median"][supported[i]->isa] = peaks[i].median() / 1e9;
  }
  result["l1_gb_s"] = l1.highest() / 1e9;
  result["l2_gb_s"] = l2.highest() / 1e9;
  result["l1_array_bytes"] = l1_array;
  result["l2_array_bytes"] = l2_array;
  for (const Evaluation& evaluation : evaluations) result["full_round"].push_back(json_of(evaluation, result));
  const auto is_shown = [widest](const nlohmann::ordered_json& round) {
    return round["isa"] == widest->isa && round["rows"] == 2;
  };
  const auto& rounds = result["full_round"];
  const nlohmann::ordered_json shown = *std::find_if(rounds.begin(), rounds.end(), is_shown);
  result["full_round_share_of_peak"] = shown["share_of_peak"];
  result["full_round_share_of_slots"] = shown["share_of_slots"];
  return result;
}

void print(const nlohmann::ordered_json& result) {
  std::printf("%-8s %22s\n", "", "peak float32 GFLOP/s");
  for (const auto& [isa, peak] : result["peak_gflops"].items()) {
    std::printf("%-8s %22.1f   (median %.1f)\n", isa.c_str(), peak.get<double>(),
                result["peak_gflops_median"][isa].get<double>());
  }
  std::printf("\nloads: L1 %.1f GB/s (%zu KiB), L2 %.1f GB/s (%zu KiB)\n", result["l1_gb_s"].get<double>(),
              result["l1_array_bytes"].get<std::size_t>() / 1024, result["l2_gb_s"].get<double>(),
              result["l2_array_bytes"].get<std::size_t>() / 1024);
  std::printf("\nfull round, n = %zu, %s\n%-8s %4s %8s %8s %8s %8s %8s %9s  %s\n", FullRound::candidates,
              arithmetic_name, "", "rows", "ns/gain", "GFLOP/s", "median", "of peak", "of slots", "flop/byte", "roof");
  for (const auto& round : result["full_round"]) {
    std::printf("%-8s %4d %8.3f %8.1f %8.1f %7.1f%% %7.1f%% %9.2f  %s, %.1f GFLOP/s\n",
                round["isa"].get<std::string>().c_str(), round["rows"].get<int>(), round["ns_per_gain"].get<double>(),
                round["gflops"].get<double>(), round["gflops_median"].get<double>(),
                100 * round["share_of_peak"].get<double>(), 100 * round["share_of_slots"].get<double>(),
                round["intensity"].get<double>(), round["roof"].get<std::string>().c_str(),
                round["roof_gflops"].get<double>());
  }
}

}  // namespace
}  // namespace maxlogdet::profiles

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("usage: roofline MACHINE COMMAND OUTPUT.json\n", stderr);
    return 2;
  }
  try {
    nlohmann::ordered_json record = {{"machine", argv[1]},
                                     {"compiler", MAXLOGDET_COMPILER " " MAXLOGDET_BUILD_TYPE},
                                     {"command", argv[2]},
                                     {"date", maxlogdet::profiles::today()},
                                     {"maxlogdet", maxlogdet::version()},
                                     {"isa", maxlogdet::active_isa()},
                                     {"turns", maxlogdet::profiles::turns},
                                     {"candidates", maxlogdet::profiles::FullRound::candidates},
                                     {"arithmetic", maxlogdet::profiles::arithmetic_name}};
    record.update(maxlogdet::profiles::measure());
    maxlogdet::profiles::print(record);
    std::ofstream file(argv[3]);
    file << record.dump(2) << '\n';
    if (!file.flush()) {
      std::fprintf(stderr, "roofline: cannot write %s; expected a file in a folder that exists\n", argv[3]);
      return 1;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "roofline: %s\n", error.what());
    return 1;
  }
  return 0;
}
