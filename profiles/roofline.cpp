// SPDX-License-Identifier: MIT
// How close the evaluation of a full round comes to what this core can do: its peak of float32 fused multiply-adds, and
// what its caches deliver. Everything is measured in turns, in short pieces, so that whatever else the machine does
// meets all of it alike. Usage: roofline MACHINE COMMAND OUTPUT.json
#include "profiles/core.hpp"
#include "profiles/full_round.hpp"
#include "sim/latency.hpp"
#include "sim/names.hpp"
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
constexpr double piece_seconds = 30e-6;  // long against a clock's read, short against a time slice

using Clock = std::chrono::steady_clock;

double seconds_of(const std::function<void()>& work, std::size_t times) {
  const auto start = Clock::now();
  for (std::size_t i = 0; i < times; ++i) work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Something to measure: `amount` of it is done in a call of `work`.
class Measurement {
 public:
  Measurement(double amount, std::function<void()> work) : amount_(amount), work_(std::move(work)) {
    while (seconds_of(work_, times_) < piece_seconds) times_ *= 2;
  }

  void take_turn() {
    work_();  // the caches are its own again
    rates_.push_back(amount_ * static_cast<double>(times_) / seconds_of(work_, times_));
  }

  double best() const { return *std::max_element(rates_.begin(), rates_.end()); }
  double median() const {
    std::vector<double> rates = rates_;
    const auto middle = rates.begin() + static_cast<std::ptrdiff_t>(rates.size() / 2);
    std::nth_element(rates.begin(), middle, rates.end());
    return *middle;
  }

 private:
  double amount_;
  std::function<void()> work_;
  std::size_t times_ = 1;
  std::vector<double> rates_;
};

struct Evaluation {
  const Core* core;
  int rows;
  Measurement rounds;
};

// As the operating system tells it, or as most cores have it.
std::size_t cache_bytes(int name, std::size_t usual) {
  const long told = sysconf(name);
  return told > 0 ? static_cast<std::size_t>(told) : usual;
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

nlohmann::ordered_json measure() {
  volatile float sink = 0;  // what is computed is used
  std::vector<const Core*> supported;
  for (const Core* core : cores) {
    if (isa_is_supported(core->isa)) supported.push_back(core);
  }
  const Core& widest = *supported.back();

  std::vector<Measurement> peaks;  // flops
  for (const Core* core : supported) {
    constexpr std::size_t steps = 1000;
    peaks.emplace_back(2.0 * steps * core->chains * core->lanes,
                       [core, &sink] { sink = core->multiply_add(steps, 0.5f, 1.0f); });
  }
  const auto loads = [&](std::size_t bytes) {
    const std::size_t count = bytes / sizeof(float) / sum_block * sum_block;
    auto memory = std::make_shared<std::vector<float>>(count + 16, 1.0f);
    void* aligned = memory->data();
    std::size_t space = memory->size() * sizeof(float);
    std::align(64, count * sizeof(float), aligned, space);
    constexpr std::size_t passes = 8;
    return Measurement(static_cast<double>(passes * count * sizeof(float)), [memory, aligned, count, &widest, &sink] {
      sink = widest.sum(static_cast<const float*>(aligned), count, passes);
    });
  };
  const std::size_t l1_array = l1_bytes() / 2;
  const std::size_t l2_array = l2_bytes() / 4;
  Measurement l1 = loads(l1_array);
  Measurement l2 = loads(l2_array);
  std::vector<Evaluation> evaluations;
  for (const int rows : {2, 3}) {
    for (const Core* core : supported) {
      const auto round = std::make_shared<FullRound>(core->isa, rows);
      evaluations.push_back({core, rows, Measurement(FullRound::candidates, [round] { (*round)(); })});
    }
  }

  sim::measure_latency("measuring", turns, [&] {
    for (Measurement& peak : peaks) peak.take_turn();
    l1.take_turn();
    l2.take_turn();
    for (Evaluation& evaluation : evaluations) evaluation.rounds.take_turn();
  });

  nlohmann::ordered_json result;
  for (std::size_t i = 0; i < supported.size(); ++i) {
    result["peak_gflops"][supported[i]->isa] = peaks[i].best() / 1e9;
    result["peak_gflops_median"][supported[i]->isa] = peaks[i].median() / 1e9;
  }
  result["l1_gb_s"] = l1.best() / 1e9;
  result["l2_gb_s"] = l2.best() / 1e9;
  result["l1_array_bytes"] = l1_array;
  result["l2_array_bytes"] = l2_array;
  for (const Evaluation& evaluation : evaluations) {
    const Core& core = *evaluation.core;
    const Arithmetic& arithmetic = gain_arithmetic[evaluation.rows - 1];
    const double peak = result["peak_gflops"][core.isa].get<double>();
    // Vector instructions a second: what the gains take, and what the core does when nothing else is asked of it.
    const double lanes = static_cast<double>(core.lanes) * sizeof(float) / element_bytes;
    const double slots = 1e9 * peak / (2.0 * core.lanes) * core.instructions_per_fma;
    const double gflops = evaluation.rounds.best() * arithmetic.flops / 1e9;
    const int operations = core.instructions_per_fma == 1 ? arithmetic.vector_operations : arithmetic.flops;
    const double slot_share = evaluation.rounds.best() * operations / lanes / slots;
    const std::size_t bytes = FullRound::bytes_per_gain(evaluation.rows);
    const double intensity = static_cast<double>(arithmetic.flops) / static_cast<double>(bytes);
    const bool in_l1 = FullRound::candidates * bytes <= l1_bytes();
    const double memory_roof = intensity * result[in_l1 ? "l1_gb_s" : "l2_gb_s"].get<double>();
    result["full_round"].push_back({
        {"rows", evaluation.rows},
        {"isa", core.isa},
        {"gflops", gflops},
        {"gflops_median", evaluation.rounds.median() * arithmetic.flops / 1e9},
        {"ns_per_gain", 1e9 / evaluation.rounds.best()},
        {"share_of_peak", gflops / peak},
        {"share_of_slots", slot_share},
        {"intensity", intensity},
        {"roof_gflops", std::min(peak, memory_roof)},
        {"roof", peak <= memory_roof ? "arithmetic"
                 : in_l1             ? "L1"
                                     : "L2"},
    });
    if (&core == &widest && evaluation.rows == 2) {
      result["full_round_share_of_peak"] = gflops / peak;
      result["full_round_share_of_slots"] = slot_share;
    }
  }
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
      std::fprintf(stderr, "%s: cannot be written\n", argv[3]);
      return 1;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "roofline: %s\n", error.what());
    return 1;
  }
  return 0;
}
