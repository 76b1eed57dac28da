// SPDX-License-Identifier: MIT
#include "kernel/information/information_mixture.hpp"

#include <algorithm>
#include <utility>

namespace maxlogdet {
namespace {

constexpr int n = state_dimension;

// Maximum number of pairs of weights balanced after a step. Without any, relaxed fell up to 5e-3 nats short of greedy
// on clustered frames in eight passes; with three or thirty, 1e-3 (docs/performance.md).
constexpr int max_balances = 4;
// A pair is balanced only if its derivatives differ by more than this share of the gain that the new selection
// promised.
constexpr double min_imbalance = 0.05;
// A line search need not be exact: it stops when the slope has fallen to this share, or after line_search_steps.
constexpr double flat_slope = 0.02;
constexpr int line_search_steps = 20;

// d/dg log det(I + g B), from the pivots of an elimination and their derivatives.
double slope_at(double g, const Information& b) noexcept {
  double a[n][n];
  double da[n][n];
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      da[i][j] = b.entry[i][j];
      a[i][j] = (i == j ? 1.0 : 0.0) + g * b.entry[i][j];
    }
  }
  double slope = 0;
  for (int c = 0; c < n; ++c) {
    const double inverse = 1 / a[c][c];
    const double relative = da[c][c] * inverse;
    slope += relative;
    for (int i = c + 1; i < n; ++i) {
      const double factor = a[i][c] * inverse;
      const double dfactor = (da[i][c] - factor * da[c][c]) * inverse;
      for (int j = c + 1; j <= i; ++j) {
        a[i][j] -= factor * a[j][c];
        da[i][j] -= dfactor * a[j][c] + factor * da[j][c];
      }
    }
  }
  return slope;
}

// The step g in [0, max_step] that maximises log det(I + g B), which is concave. Alternates bisection with false
// position, which alone converges slowly where the slope has a pole just beyond `max_step`.
double best_step(const Information& b, double max_step) noexcept {
  double low = 0;
  double high = max_step;
  double at_low = slope_at(low, b);
  double at_high = slope_at(high, b);
  const double flat = flat_slope * at_low;
  if (!(at_low > 0)) return 0;
  if (at_high >= 0) return max_step;
  for (int i = 0; i < line_search_steps; ++i) {
    const double share = i % 2 == 0 ? at_low / (at_low - at_high) : 0.5;
    const double g = low + (high - low) * share;
    const double slope = slope_at(g, b);
    if (slope > 0) {
      low = g;
      at_low = slope;
      if (slope < flat) break;
    } else {
      high = g;
      at_high = slope;
    }
  }
  return low;
}

// W A W^T for a symmetric A and a lower triangular W.
Information whitened(const double* w, const Information& a) noexcept {
  const auto row_of = [w](int i) { return w + static_cast<std::size_t>(simd::padded_dimension * i); };
  double left[n][n];  // W A
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      left[i][j] = row_of(i)[0] * a.entry[0][j];
      for (int d = 1; d <= i; ++d) left[i][j] += row_of(i)[d] * a.entry[d][j];
    }
  }
  Information result;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = left[i][0] * row_of(j)[0];
      for (int d = 1; d <= j; ++d) sum += left[i][d] * row_of(j)[d];
      result.entry[i][j] = sum;
      result.entry[j][i] = sum;
    }
  }
  return result;
}

// M^-1 = W^T W.
Information inverse_information(const double* w) noexcept {
  Information result;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = 0;
      for (int c = i; c < n; ++c) sum += w[simd::padded_dimension * c + i] * w[simd::padded_dimension * c + j];
      result.entry[i][j] = sum;
      result.entry[j][i] = sum;
    }
  }
  return result;
}

// tr(A B).
double trace_of_product(const Information& a, const Information& b) noexcept {
  double by_column[n] = {};
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) by_column[j] += a.entry[i][j] * b.entry[i][j];
  }
  return ((by_column[0] + by_column[1]) + (by_column[2] + by_column[3])) + (by_column[4] + by_column[5]);
}

}  // namespace

bool InformationMixture::reset(const Information& first) noexcept {
  count_ = 1;
  selections_[0] = first;
  weights_[0] = 1;
  sum_ = first;
  return refactorise();
}

bool InformationMixture::refactorise() noexcept { return factor_.reset(&sum_.entry[0][0]); }

bool InformationMixture::add(const Information& next, double min_promise) noexcept {
  if (count_ == max_selections) merge_lightest();
  const Information towards = difference(next, sum_);
  const double promised = trace_of_product(inverse_information(inverse()), towards);
  if (!(promised > min_promise)) return false;
  const double step = best_step(whitened(inverse(), towards), 1);
  if (!(step > 0)) return false;
  for (int j = 0; j < count_; ++j) weights_[j] *= 1 - step;
  weights_[count_] = step;
  selections_[count_] = next;
  ++count_;
  add_scaled(step, towards, sum_);
  return refactorise() && balance(min_imbalance * promised);
}

bool InformationMixture::balance(double min_difference) noexcept {
  for (int i = 0; i < max_balances; ++i) {
    const Information inverse_sum = inverse_information(inverse());
    int max_place = -1;
    int min_place = -1;
    double highest = 0;
    double lowest = 0;
    for (int j = 0; j < count_; ++j) {
      const double derivative = trace_of_product(inverse_sum, selections_[j]);  // of log det, by the weight of j
      if (max_place < 0 || derivative > highest) {
        max_place = j;
        highest = derivative;
      }
      if (weights_[j] > 0 && (min_place < 0 || derivative < lowest)) {
        min_place = j;
        lowest = derivative;
      }
    }
    if (!(highest - lowest > min_difference)) return true;
    if (!move(min_place, max_place)) return false;
  }
  return true;
}

bool InformationMixture::move(int from, int to) noexcept {
  const Information towards = difference(selections_[to], selections_[from]);
  const double step = best_step(whitened(inverse(), towards), weights_[from]);
  weights_[from] -= step;
  weights_[to] += step;
  add_scaled(step, towards, sum_);
  return refactorise();
}

// Merges the two selections of minimum weight into one of the same information in the sum.
void InformationMixture::merge_lightest() noexcept {
  for (int place : {max_selections - 1, max_selections - 2}) {
    const int lightest = static_cast<int>(std::min_element(weights_, weights_ + place + 1) - weights_);
    std::swap(weights_[lightest], weights_[place]);
    std::swap(selections_[lightest], selections_[place]);
  }
  const double both = weights_[max_selections - 2] + weights_[max_selections - 1];
  const double share = both > 0 ? weights_[max_selections - 1] / both : 0;
  add_scaled(share, difference(selections_[max_selections - 1], selections_[max_selections - 2]),
             selections_[max_selections - 2]);
  weights_[max_selections - 2] = both;
  count_ = max_selections - 1;
}

}  // namespace maxlogdet
