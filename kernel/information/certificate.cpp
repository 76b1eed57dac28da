// SPDX-License-Identifier: MIT
#include "kernel/information/certificate.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/information/information_mixture.hpp"
#include "simd/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet {
namespace {

using simd::double_unit_roundoff;

// Rounding error of the sums in units of 2^-53, relative to the magnitudes of their terms (docs/numerics.md).
constexpr double sum_errors = 128;

// The minimum improvement that a pass must promise, nats: less is rounding.
constexpr double min_promise = 1e-9;
// Guarantees termination: stops when `patience` passes improve the bound by less than `min_progress`, nats.
constexpr std::size_t patience = 32;
constexpr double min_progress = 1e-6;

// A sum, and that of its terms' magnitudes, to which its rounding error is proportional.
struct Sum {
  double value = 0;
  double magnitude = 0;
  void add(double term, double size) noexcept {
    value += term;
    magnitude += size;
  }
};

// -2 sum log W_cc + tr(W M0 W^T) - 6, the bound without candidates.
Sum bound_of_prior(const double* w, const Information& prior) noexcept {
  Sum sum;
  sum.add(-state_dimension, state_dimension);
  for (int c = 0; c < state_dimension; ++c) {
    const double* const row = w + static_cast<std::size_t>(simd::padded_dimension * c);
    const double log = std::log(row[c]);
    sum.add(-2 * log, 2 * std::abs(log));
    for (int i = 0; i <= c; ++i) {
      for (int j = 0; j <= c; ++j) {
        const double term = row[i] * prior.entry[i][j] * row[j];
        sum.add(term, std::abs(term));
      }
    }
  }
  return sum;
}

// The bound that W proves; `top` becomes the candidates of maximum trace.
double bound_at(const Problem& problem, const double* w, const Information& prior, std::size_t budget, TopTraces& top,
                TraceMemory& memory) noexcept {
  const std::size_t required = problem.required_count;
  problem.evaluator.traces(w, problem.required, required, memory.exact.data());
  double traces = std::accumulate(memory.exact.data(), memory.exact.data() + required, 0.0);
  top = find_top_traces(problem, w, budget - required, top.threshold, memory);
  traces += top.sum;

  const auto count = static_cast<double>(required + top.count);
  const double error = double_unit_roundoff * trace_root_error(problem.candidates, w);  // of the root of a trace
  const Sum rest = bound_of_prior(w, prior);
  const double rounding = (sum_errors + count) * double_unit_roundoff * (traces + rest.magnitude) +
                          error * (3 * std::sqrt(count * traces) + 2 * count * error);
  const double bound = rest.value + traces + rounding;
  return bound < infinity ? bound : infinity;  // also if it is NaN
}

}  // namespace

double upper_bound(const Problem& problem, const Incumbent& incumbent, std::size_t passes, const Deadline& deadline,
                   TraceMemory& memory) noexcept {
  const Information prior = prior_information(problem.prior);
  const std::size_t budget = incumbent.budget;
  TopTraces top{nullptr, 0, 0, first_guess(budget)};
  double lowest = bound_at(problem, incumbent.inverse, prior, budget, top, memory);
  if (passes == 0) return lowest;

  const Information required = plus_blocks(problem.candidates, problem.required, problem.required_count, prior);
  InformationMixture mixture;
  if (!mixture.reset(plus_blocks(problem.candidates, incumbent.selected, incumbent.count, prior))) return lowest;
  double at_last_check = infinity;
  for (std::size_t pass = 0; pass < passes && !deadline.has_passed(); ++pass) {
    if (pass % patience == patience - 1) {
      if (at_last_check - lowest < min_progress) break;
      at_last_check = lowest;
    }
    const Information best = plus_blocks(problem.candidates, top.candidates, top.count, required);
    if (!mixture.add(best, min_promise)) break;
    lowest = std::min(lowest, bound_at(problem, mixture.inverse(), prior, budget, top, memory));
  }
  return lowest;
}

}  // namespace maxlogdet
