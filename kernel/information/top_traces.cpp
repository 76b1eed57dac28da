// SPDX-License-Identifier: MIT
#include "kernel/information/top_traces.hpp"

#include "kernel/information/whitened_rows.hpp"
#include "simd/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace maxlogdet {
namespace {

using simd::float_unit_roundoff;

// Of the root of a trace, by the sum of 18 squares, in units of 2^-24 (docs/numerics.md).
constexpr double sum_errors = 16;
// Of the root of a trace, by underflow in its squares.
constexpr double underflow_error = 1e-18;
// |Y| within which no float32 operation overflows, or loses more to underflow than that.
constexpr double largest_norm = 1e15;
constexpr double smallest_norm = 1e-12;

// The traces of listed candidates are screened down to about so many more than wanted: one of them costs float64 about
// as long as float32 takes to count 128.
std::size_t enough(std::size_t n, std::size_t wanted) noexcept { return wanted + wanted / 16 + n / 128 + 8; }

// A value that at least `wanted` of `count` are not below (so many are not negative), and not many more unless they are
// equal. In growing steps from a guess, then by turns in half and where counts that grow evenly would be met.
float threshold_for(const Evaluator& evaluator, const float* values, std::size_t count, std::size_t wanted,
                    float guess) noexcept {
  const std::size_t most = enough(count, wanted);
  if (!(guess > 0)) guess = first_guess(wanted);
  float factor = 1.2F;
  float low = 0;
  float high = std::numeric_limits<float>::max();
  std::size_t at_low = count;
  std::size_t at_high = 0;
  bool is_bracketed = false;
  for (bool halve = false;; halve = !halve) {
    const std::size_t found = evaluator.count_at_least(values, count, guess);
    if (found >= wanted) {
      if (found <= most) return guess;
      low = guess;
      at_low = found;
    } else {
      high = guess;
      at_high = found;
    }
    constexpr float smallest = std::numeric_limits<float>::min();
    constexpr float largest = std::numeric_limits<float>::max() / 16;
    is_bracketed = is_bracketed || (low > 0 && high < std::numeric_limits<float>::max());
    if (!is_bracketed) {
      if (low > 0 ? guess > largest : guess < 16 * smallest) return low;
      guess *= low > 0 ? factor : 1 / factor;
      factor = std::min(8.0F, factor * factor);
      continue;
    }
    const std::size_t aim = (wanted + most) / 2;
    const auto excess = static_cast<double>(at_low - aim);
    const double share = excess / static_cast<double>(at_low - at_high);
    guess = low + (high - low) * (halve ? 0.5F : static_cast<float>(std::min(0.9, std::max(0.1, share))));
    if (!(guess > low && guess < high)) return low;
  }
}

// Lists the free candidates that may be among the `wanted` of largest exact trace, in ascending order.
std::size_t list_contenders(const Problem& problem, const double* w, std::size_t wanted, float& threshold,
                            TraceMemory& memory) noexcept {
  const std::size_t n = problem.candidates.size();
  std::uint32_t* const contenders = memory.contenders.data();
  const double unit_error = trace_root_error(problem.candidates, w);  // 8 |W| |h|
  const double norm = unit_error / 8;
  if (!(norm < largest_norm && norm > smallest_norm) || wanted >= problem.free_count) {
    std::size_t listed = 0;
    for (std::size_t i = 0; i < n; ++i) {
      contenders[listed] = static_cast<std::uint32_t>(i);
      listed += problem.is_free[i] != 0 ? 1 : 0;
    }
    return listed;
  }
  problem.evaluator.traces(w, problem.is_free, n, memory.traces);
  threshold = threshold_for(problem.evaluator, memory.traces, n, wanted, threshold);
  const double error = unit_error * float_unit_roundoff + underflow_error;
  const double root =
      std::sqrt(static_cast<double>(threshold)) * (1 - 2 * sum_errors * float_unit_roundoff) - 2 * error;
  const float least = root > 0 ? static_cast<float>(root * root * (1 - 1e-6)) : 0.0F;
  return problem.evaluator.list_at_least(memory.traces, n, least, contenders);
}

}  // namespace

TraceMemory::TraceMemory(std::size_t capacity)
    : traces(capacity + simd::tile_size),
      contenders(capacity + Evaluator::list_room),
      exact(capacity),
      places(capacity),
      top(capacity) {}

double trace_root_error(const Candidates& candidates, const double* w) noexcept {
  const double squares = bound_whitened_rows(w, candidates.column_max()).squares;
  return 8 * std::sqrt(std::max(candidates.rows(), 1) * squares);
}

TopTraces find_top_traces(const Problem& problem, const double* w, std::size_t wanted, float guess,
                          TraceMemory& memory) noexcept {
  TopTraces top{memory.top.data(), 0, 0, guess};
  if (wanted == 0) return top;
  const std::size_t listed = list_contenders(problem, w, wanted, top.threshold, memory);
  if (listed == 0) return top;
  const std::uint32_t* const contenders = memory.contenders.data();
  double* const exact = memory.exact.data();
  problem.evaluator.exact_traces(w, contenders, listed, exact);

  std::size_t last = listed - 1;  // the last one in order of traces, then of indices, that is taken
  if (listed > wanted) {
    std::uint32_t* const places = memory.places.data();
    std::iota(places, places + listed, 0U);
    std::nth_element(places, places + (wanted - 1), places + listed, [exact](std::uint32_t a, std::uint32_t b) {
      return exact[a] > exact[b] || (exact[a] == exact[b] && a < b);
    });
    last = places[wanted - 1];
  }
  for (std::size_t j = 0; j < listed; ++j) {
    if (listed > wanted && !(exact[j] > exact[last] || (exact[j] == exact[last] && j <= last))) continue;
    memory.top[top.count++] = contenders[j];
    top.sum += exact[j];
  }
  return top;
}

}  // namespace maxlogdet
