// SPDX-License-Identifier: MIT
// Writes what certificates prove and what the relaxed strategy gains, as tables in Markdown on stdout, each after a
// line "table NAME". Times are minima of interleaved calls.
#include "bench/problem.hpp"
#include "sim/scene.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>

namespace maxlogdet::bench {
namespace {

constexpr Blocks all_blocks[] = {Blocks::two_rows, Blocks::two_rows_measurement, Blocks::three_rows,
                                 Blocks::three_rows_measurement};
constexpr double seconds_per_case = 0.02;
constexpr int least_calls = 3;

struct Measured {
  double microseconds = std::numeric_limits<double>::infinity();
  double log_det = 0;
  double gap = 0;
};

// Calls every variant by turns.
std::vector<Measured> measure(const BlockStore& blocks, const std::vector<Options>& variants) {
  using Clock = std::chrono::steady_clock;
  Selector selector(blocks.size());
  std::vector<Measured> results(variants.size());
  const auto begin = Clock::now();
  for (int call = 0; call < least_calls || Clock::now() - begin < std::chrono::duration<double>(seconds_per_case);
       ++call) {
    for (std::size_t v = 0; v < variants.size(); ++v) {
      const auto start = Clock::now();
      const Selection selection = selector.select(blocks, variants[v]);
      const double elapsed = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
      results[v].microseconds = std::min(results[v].microseconds, elapsed);
      results[v].log_det = selection.log_det;
      results[v].gap = selection.upper_bound - selection.log_det;
    }
  }
  return results;
}

std::vector<Options> certified(std::size_t budget) {
  std::vector<Options> variants(4);
  for (Options& options : variants) options.budget = budget;
  for (std::size_t v = 1; v < 4; ++v) variants[v].certify = true;
  variants[2].certificate_passes = 1;
  variants[3].certificate_passes = 8;
  return variants;
}

void write_certificates() {
  std::printf("table certificates\n");
  std::printf(
      "| family | blocks | k = 20: gap | 1 pass | 8 passes | k = 100: gap | 1 pass | 8 passes | bound, µs | a pass, µs "
      "|\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& family : synthetic_families()) {
    for (const Blocks blocks : all_blocks) {
      std::printf("| %s | %s |", family.c_str(), to_string(blocks));
      for (const std::size_t k : {std::size_t{20}, std::size_t{100}}) {
        const auto r = measure(stores_of(family, 2000, blocks)[0], certified(k));
        std::printf(" %.4f | %.4f | %.4f |", r[1].gap, r[2].gap, r[3].gap);
        if (k == 100) {
          std::printf(" %.1f | %.1f |\n", r[1].microseconds - r[0].microseconds,
                      (r[3].microseconds - r[1].microseconds) / 8);
        }
      }
    }
  }
  std::printf("table largest_gaps\n");
  std::printf("| k | n | gap | 1 pass | 8 passes |\n|---|---|---|---|---|\n");
  for (const std::size_t k : {std::size_t{20}, std::size_t{100}}) {
    for (const std::size_t n : {std::size_t{500}, std::size_t{2000}, std::size_t{20000}}) {
      double largest[4] = {};
      for (const std::string& family : synthetic_families()) {
        for (const Blocks blocks : all_blocks) {
          Selector selector(n);
          const std::vector<Options> variants = certified(k);
          for (std::size_t v = 1; v < 4; ++v) {
            const Selection selection = selector.select(stores_of(family, n, blocks)[0], variants[v]);
            largest[v] = std::max(largest[v], selection.upper_bound - selection.log_det);
          }
        }
      }
      std::printf("| %zu | %zu | %.4f | %.4f | %.4f |\n", k, n, largest[1], largest[2], largest[3]);
    }
  }
}

std::vector<Options> lazy_and_relaxed(std::size_t budget) {
  std::vector<Options> variants(2);
  for (Options& options : variants) options.budget = budget;
  variants[1].strategy = Strategy::relaxed;
  return variants;
}

void write_cell(const BlockStore& blocks, std::size_t k) {
  const auto r = measure(blocks, lazy_and_relaxed(k));
  std::printf(" %.1f, %+.4f |", r[0].microseconds / r[1].microseconds, r[1].log_det - r[0].log_det + 0.0);
}

void write_relaxed() {
  constexpr std::size_t budgets[] = {60, 100, 200, 500};
  std::printf("table relaxed\n");
  std::printf("| family | blocks | n | k = 60 | k = 100 | k = 200 | k = 500 |\n|---|---|---|---|---|---|---|\n");
  for (const std::string& family : synthetic_families()) {
    for (const Blocks blocks : all_blocks) {
      for (const std::size_t n : {std::size_t{20000}, std::size_t{100000}}) {
        std::printf("| %s | %s | %zu |", family.c_str(), to_string(blocks), n);
        for (const std::size_t k : budgets) write_cell(stores_of(family, n, blocks)[0], k);
        std::printf("\n");
      }
    }
  }
  std::printf("table relaxed_over_n\n");
  std::printf("| n | k = 60 | k = 100 | k = 200 | k = 500 |\n|---|---|---|---|---|\n");
  for (const std::size_t n : {std::size_t{1000}, std::size_t{2000}, std::size_t{5000}, std::size_t{10000},
                              std::size_t{20000}, std::size_t{50000}, std::size_t{100000}}) {
    std::printf("| %zu |", n);
    for (const std::size_t k : budgets) write_cell(stores_of("euroc_like", n, Blocks::two_rows)[0], k);
    std::printf("\n");
  }
}

// Over frames of other seeds than those of the other tables.
void write_relaxed_frames() {
  std::printf("table relaxed_frames\n");
  std::printf("| family | selections | lowest Δ | mean Δ | highest Δ | below -0.001 |\n|---|---|---|---|---|---|\n");
  for (const sim::Scene scene : sim::scenes) {
    double lowest = 0;
    double highest = 0;
    double sum = 0;
    int count = 0;
    int below = 0;
    for (std::uint64_t seed = 2; seed < 22; ++seed) {
      for (const std::size_t n : {std::size_t{1000}, std::size_t{2000}, std::size_t{5000}, std::size_t{20000}}) {
        const sim::Frame frame = make_scene(scene, n, seed);
        for (int kind = 0; kind < 4; ++kind) {
          BlockOptions options;
          if (kind % 2 == 1) options.weighting = Weighting::measurement;
          if (kind >= 2) options.third = ThirdMeasurement::stereo;
          BlockStore blocks(n);
          build_blocks(frame, options, blocks);
          Selector selector(n);
          for (const std::size_t k : {std::size_t{60}, std::size_t{100}, std::size_t{200}, std::size_t{500}}) {
            const std::vector<Options> variants = lazy_and_relaxed(k);
            const double exact = selector.select(blocks, variants[0]).log_det;
            const double delta = selector.select(blocks, variants[1]).log_det - exact;
            lowest = std::min(lowest, delta);
            highest = std::max(highest, delta);
            sum += delta;
            ++count;
            if (delta < -1e-3) ++below;
          }
        }
      }
    }
    std::printf("| %s | %d | %+.4f | %+.4f | %+.4f | %d |\n", to_string(scene).c_str(), count, lowest, sum / count,
                highest, below);
  }
}

}  // namespace
}  // namespace maxlogdet::bench

int main() {
  using namespace maxlogdet;
  std::printf("isa %s\ncompiler %s\n", active_isa(), MAXLOGDET_COMPILER);
  bench::write_certificates();
  bench::write_relaxed();
  bench::write_relaxed_frames();
}
