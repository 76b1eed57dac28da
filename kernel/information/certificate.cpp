// SPDX-License-Identifier: MIT
#include "kernel/information/certificate.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/information/whitened_rows.hpp"
#include "simd/rounding.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

using simd::double_unit_roundoff;

// Rounding error of the sums in units of 2^-53, relative to the magnitudes of their terms (docs/numerics.md).
constexpr double sum_errors = 128;

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
Sum bound_of_prior(const double* w, const double* prior) noexcept {
  Sum sum;
  sum.add(-state_dimension, state_dimension);
  for (int c = 0; c < state_dimension; ++c) {
    const double* const row = w + static_cast<std::size_t>(simd::padded_dimension * c);
    const double log = std::log(row[c]);
    sum.add(-2 * log, 2 * std::abs(log));
    for (int i = 0; i <= c; ++i) {
      for (int j = 0; j <= c; ++j) {
        const double term = row[i] * prior[state_dimension * i + j] * row[j];
        sum.add(term, std::abs(term));
      }
    }
  }
  return sum;
}

// An upper bound of the rounding error of the root of a trace in float64, in units of 2^-53, 8 |W| |h| for all rows.
double trace_root_error(const Candidates& candidates, const double* w) noexcept {
  const double squares = bound_whitened_rows(w, candidates.column_max).squares;
  return 8 * std::sqrt(std::max(candidates.rows, 1) * squares);
}

// Lists in `order` the candidates i < n with is_open[i] != 0, the `count` of largest trace first, of equal ones the
// first. Returns how many are open.
std::size_t list_by_trace(const unsigned char* is_open, std::size_t n, std::size_t count, const double* traces,
                          std::uint32_t* order) noexcept {
  std::size_t open = 0;
  for (std::size_t i = 0; i < n; ++i) {
    order[open] = static_cast<std::uint32_t>(i);
    open += is_open[i] != 0 ? 1 : 0;
  }
  if (count > 0 && count < open) {
    std::nth_element(order, order + count - 1, order + open, [traces](std::uint32_t a, std::uint32_t b) {
      return traces[a] > traces[b] || (traces[a] == traces[b] && a < b);
    });
  }
  return open;
}

}  // namespace

double upper_bound(const Problem& problem, const double* w, std::size_t budget, double* traces,
                   std::uint32_t* order) noexcept {
  const Candidates& candidates = problem.candidates;
  candidates.exact().traces(candidates.planes, w, candidates.count, traces);
  double sum = 0;
  for (std::size_t j = 0; j < problem.required_count; ++j) sum += traces[simd::number(problem.required[j])];
  const std::size_t wanted = budget - problem.required_count;
  const std::size_t taken = std::min(wanted, list_by_trace(problem.is_free, candidates.count, wanted, traces, order));
  std::sort(order, order + taken);  // one order of additions everywhere
  double top = 0;
  for (std::size_t j = 0; j < taken; ++j) top += traces[order[j]];
  sum += top;

  const auto count = static_cast<double>(problem.required_count + taken);
  const double error = double_unit_roundoff * trace_root_error(candidates, w);
  const Sum rest = bound_of_prior(w, problem.prior);
  const double rounding = (sum_errors + count) * double_unit_roundoff * (sum + rest.magnitude) +
                          error * (3 * std::sqrt(count * sum) + 2 * count * error);
  const double bound = rest.value + sum + rounding;
  return bound < infinity ? bound : infinity;  // also if it is NaN
}

}  // namespace maxlogdet
