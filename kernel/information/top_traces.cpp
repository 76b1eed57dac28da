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

// Relative error of the root of a trace, from the sum of 18 squares, in units of 2^-24 (docs/numerics.md).
constexpr double sum_errors = 16;
// Absolute error of the root of a trace, from underflow of its squares.
constexpr double underflow_error = 1e-18;
// For |Y| between these no float32 operation overflows, or loses more than that to underflow.
constexpr double largest_norm = 1e15;
constexpr double smallest_norm = 1e-12;

constexpr float max_float = std::numeric_limits<float>::max();
constexpr float min_float = std::numeric_limits<float>::min();

// The maximum number of contenders for the k largest of n traces: one more takes float64 about as long as float32 takes
// to count 128.
std::size_t max_contenders(std::size_t n, std::size_t k) noexcept { return k + k / 16 + n / 128 + 8; }

// Bounds of a threshold: too many values, at_low, reach `low`; too few, at_high, reach `high`.
struct Bracket {
  float low;
  float high;
  std::size_t at_low;
  std::size_t at_high;

  bool is_bounded() const noexcept { return low > 0 && high < max_float; }

  void narrow(float value, std::size_t reached, std::size_t k) noexcept {
    if (reached >= k) {
      low = value;
      at_low = reached;
    } else {
      high = value;
      at_high = reached;
    }
  }

  // Where `count` values would reach, if their number fell linearly from low to high; not too close to either.
  float interpolated(std::size_t count) const noexcept {
    const auto excess = static_cast<double>(at_low - count);
    const double share = excess / static_cast<double>(at_low - at_high);
    return low + (high - low) * static_cast<float>(std::min(0.9, std::max(0.1, share)));
  }
};

// A threshold that at least k of `count` values reach, and at most max_contenders() unless values are equal; at least k
// are >= 0. Moves the guess by increasing factors until it is bracketed, then alternates interpolation and bisection.
float threshold_for(const Evaluator& evaluator, const float* values, std::size_t count, std::size_t k,
                    float guess) noexcept {
  const std::size_t max_reached = max_contenders(count, k);
  if (!(guess > 0)) guess = first_guess(k);
  Bracket bracket{0, max_float, count, 0};
  float factor = 1.2F;
  for (bool halve = false;; halve = !halve) {
    const std::size_t reached = evaluator.count_at_least(values, count, guess);
    if (reached >= k && reached <= max_reached) return guess;
    bracket.narrow(guess, reached, k);
    if (!bracket.is_bounded()) {
      const bool is_too_low = bracket.low > 0;
      if (is_too_low ? guess > max_float / 16 : guess < 16 * min_float) return bracket.low;
      guess *= is_too_low ? factor : 1 / factor;
      factor = std::min(8.0F, factor * factor);
      continue;
    }
    const std::size_t aim = (k + max_reached) / 2;
    guess = halve ? bracket.low + (bracket.high - bracket.low) * 0.5F : bracket.interpolated(aim);
    if (!(guess > bracket.low && guess < bracket.high)) return bracket.low;
  }
}

// Lists in ascending order the free candidates whose exact trace may be among the k largest.
std::size_t list_contenders(const Problem& problem, const double* w, std::size_t k, float& threshold,
                            TraceMemory& memory) noexcept {
  const std::size_t n = problem.candidates.count;
  Candidate* const contenders = memory.contenders.data();
  const double unit_error = trace_root_error(problem.candidates, w);  // 8 |W| |h|
  const double norm = unit_error / 8;
  if (!(norm < largest_norm && norm > smallest_norm) || k >= problem.free_count)
    return list_flagged(problem.is_free, n, contenders);
  problem.evaluator.screen_traces(w, problem.is_free, n, memory.traces);
  threshold = threshold_for(problem.evaluator, memory.traces, n, k, threshold);
  const double error = unit_error * float_unit_roundoff + underflow_error;
  const double root =
      std::sqrt(static_cast<double>(threshold)) * (1 - 2 * sum_errors * float_unit_roundoff) - 2 * error;
  const float min_trace = root > 0 ? static_cast<float>(root * root * (1 - simd::sum_room)) : 0.0F;
  return problem.evaluator.list_at_least(memory.traces, n, min_trace, contenders);
}

}  // namespace

TraceMemory::TraceMemory(std::size_t capacity)
    : traces(capacity + simd::tile_size),
      contenders(capacity + Evaluator::list_room),
      exact(capacity),
      order(capacity),
      top(capacity) {}

double trace_root_error(const Candidates& candidates, const double* w) noexcept {
  const double squares = bound_whitened_rows(w, candidates.column_max).squares;
  return 8 * std::sqrt(std::max(candidates.rows, 1) * squares);
}

TopTraces find_top_traces(const Problem& problem, const double* w, std::size_t k, float guess,
                          TraceMemory& memory) noexcept {
  TopTraces top{memory.top.data(), 0, 0, guess};
  if (k == 0) return top;
  const std::size_t listed = list_contenders(problem, w, k, top.threshold, memory);
  if (listed == 0) return top;
  const Candidate* const contenders = memory.contenders.data();
  double* const exact = memory.exact.data();
  problem.evaluator.traces(w, contenders, listed, exact);

  std::size_t last = listed - 1;  // the last one taken, by descending trace, then by index
  if (listed > k) {
    std::uint32_t* const order = memory.order;
    std::iota(order, order + listed, 0U);
    std::nth_element(order, order + (k - 1), order + listed, [exact](std::uint32_t a, std::uint32_t b) {
      return exact[a] > exact[b] || (exact[a] == exact[b] && a < b);
    });
    last = order[k - 1];
  }
  for (std::size_t j = 0; j < listed; ++j) {
    if (listed > k && !(exact[j] > exact[last] || (exact[j] == exact[last] && j <= last))) continue;
    memory.top[top.count++] = contenders[j];
    top.sum += exact[j];
  }
  return top;
}

}  // namespace maxlogdet
