// SPDX-License-Identifier: MIT
// The certificate: log det is below its tangent at the answer, and of the tangent the largest terms are an upper bound,
// proved with its rounding in docs/numerics.md. Groups are ignored, which can only raise it.
#include "kernel/search/search.hpp"
#include "simd/gain_filter.hpp"

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

}  // namespace

// Lists the free candidates in by_trace_, the `count` of largest trace first, of equal ones the first. Returns how many
// are free.
std::size_t Search::list_by_trace(std::size_t count) noexcept {
  const double* const traces = relative_gains_.data();
  std::uint32_t* const order = by_trace_.data();
  std::size_t open = 0;
  for (std::size_t i = 0; i < candidates_.count; ++i) {
    order[open] = static_cast<std::uint32_t>(i);
    open += constraints_.free()[i] != 0 ? 1 : 0;
  }
  if (count > 0 && count < open) {
    std::nth_element(order, order + count - 1, order + open, [traces](std::uint32_t a, std::uint32_t b) {
      return traces[a] > traces[b] || (traces[a] == traces[b] && a < b);
    });
  }
  return open;
}

// Over all selections of at most `budget` candidates that hold all required ones and otherwise only free ones;
// +infinity where nothing can be proved.
double Search::bound_of_traces(std::size_t budget) noexcept {
  double* const traces = relative_gains_.data();
  candidates_.exact().traces(candidates_.planes, factor_.inverse(), candidates_.count, traces);
  double sum = 0;
  const std::size_t required = constraints_.required_count();
  for (std::size_t j = 0; j < required; ++j) sum += traces[simd::number(constraints_.required()[j])];
  const std::size_t wanted = budget - required;
  const std::size_t taken = std::min(wanted, list_by_trace(wanted));
  std::uint32_t* const order = by_trace_.data();
  std::sort(order, order + taken);  // one order of additions everywhere
  double top = 0;
  for (std::size_t j = 0; j < taken; ++j) top += traces[order[j]];
  sum += top;

  const auto count = static_cast<double>(required + taken);
  // Of the root of a trace, in units of 2^-53: 8 |W| |h| for all rows.
  const double squares = factor_.bound_rows(candidates_.column_max).squares;
  const double error = double_unit_roundoff * 8 * std::sqrt(std::max(candidates_.rows, 1) * squares);
  const Sum rest = bound_of_prior(factor_.inverse(), prior_.entries);
  const double rounding = (sum_errors + count) * double_unit_roundoff * (sum + rest.magnitude) +
                          error * (3 * std::sqrt(count * sum) + 2 * count * error);
  const double bound = rest.value + sum + rounding;
  return bound < infinity ? bound : infinity;  // also if it is NaN
}

// Infinite also where log det exceeds the bound by more than rounding explains (docs/numerics.md). Rounding may put the
// computed log det of an optimal answer above it: the bound is then log det.
double Search::upper_bound() noexcept {
  const double relative_error = factor_.relative_error();
  if (!(relative_error < hopeless_error)) return infinity;
  // If no more candidates may be selected, no selection is longer than the answer, even with groups: all bases of a
  // matroid have the same size.
  const std::size_t all = constraints_.required_count() + constraints_.free_count();
  const double bound = bound_of_traces(remaining_ == 0 ? size_ : std::min(budget_, all));
  const double excess = log_det() - bound;
  if (!(excess > 0)) return bound;
  const double explained = 2 * state_dimension * relative_error + 1e-9;
  return excess <= explained ? log_det() : infinity;
}

}  // namespace maxlogdet
