// SPDX-License-Identifier: MIT
#include "kernel/information/certificate.hpp"

#include "kernel/information/information_mixture.hpp"
#include "kernel/information/top_traces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;
// In units of 2^-53, relative to the magnitudes that are summed (docs/numerics.md).
constexpr double sum_errors = 128;

// What a pass has to promise, nats: less is rounding.
constexpr double min_promise = 1e-9;
// Passes in which the bound has to fall by that much, nats, for more of them to be made: a number of passes without end
// ends.
constexpr std::size_t patience = 32;
constexpr double min_progress = 1e-6;

// A value, and the sum of magnitudes that its rounding error is in proportion to.
struct Sum {
  double value = 0;
  double magnitude = 0;
  void add(double term, double size) noexcept {
    value += term;
    magnitude += size;
  }
};

// -2 sum log W_cc + tr(W M0 W^T) - 6, what the bound is without candidates.
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

// The bound that W proves, and with it which candidates it takes for the best.
double bound_at(Search& search, const double* w, const Information& prior, std::size_t budget,
                TopTraces& top) noexcept {
  const std::size_t required = search.constraints.required_count();
  search.evaluator.exact_traces(w, search.constraints.required(), required, search.relative_gains);
  double traces = 0;
  for (std::size_t j = 0; j < required; ++j) traces += search.relative_gains[j];
  top = find_top_traces(search, w, budget - required, top.threshold);
  traces += top.sum;

  const auto count = static_cast<double>(required + top.count);
  const double error = unit_roundoff * trace_root_error(search, w);  // of the root of each
  const Sum rest = bound_of_prior(w, prior);
  const double rounding = (sum_errors + count) * unit_roundoff * (traces + rest.magnitude) +
                          error * (3 * std::sqrt(count * traces) + 2 * count * error);
  const double bound = rest.value + traces + rounding;
  return bound < infinity ? bound : infinity;  // NaN too
}

}  // namespace

double upper_bound(Search& search, std::size_t passes) noexcept {
  const Information prior = prior_information(search.prior_matrix);
  // Where no more may be selected nothing is longer than the answer, full groups or not (a matroid's bases are of one
  // size).
  const std::size_t budget =
      search.remaining == 0
          ? search.selected
          : std::min(search.budget, search.constraints.required_count() + search.constraints.free_count());
  TopTraces top{nullptr, 0, 0, first_guess(budget)};
  double least = bound_at(search, search.factor.inverse(), prior, budget, top);
  if (passes == 0) return least;

  Information required = prior;
  add_blocks(search.candidates, search.constraints.required(), search.constraints.required_count(), required);
  InformationMixture mixture;
  Information selected = prior;
  add_blocks(search.candidates, search.indices, search.selected, selected);
  if (!mixture.reset(selected)) return least;
  double at_last_check = infinity;
  for (std::size_t pass = 0; pass < passes && !search.deadline.has_passed(); ++pass) {
    if (pass % patience == patience - 1) {
      if (at_last_check - least < min_progress) break;
      at_last_check = least;
    }
    Information best = required;
    add_blocks(search.candidates, top.candidates, top.count, best);
    if (!mixture.add(best, min_promise)) break;
    least = std::min(least, bound_at(search, mixture.inverse(), prior, budget, top));
  }
  return least;
}

}  // namespace maxlogdet
