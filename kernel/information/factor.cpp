// SPDX-License-Identifier: MIT
#include "kernel/information/factor.hpp"

#include "kernel/base/memory.hpp"
#include "simd/gain_filter.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

using simd::double_unit_roundoff;

constexpr int n = InformationFactor::n;

// Of a Cholesky pivot of a prior.
constexpr double smallest_relative_pivot = 1e-14;

// A constant of the error analysis in docs/numerics.md, rounded up.
constexpr double update_error = 192 * double_unit_roundoff;
// The norm of W is recomputed after each of the first blocks, which change it most, and then at this interval.
constexpr std::uint32_t norm_interval = 8;

// Scaling x by 4^k scales this by 2^k, exactly.
double power_of_two_near_root(double x) noexcept {
  return std::ldexp(1.0, static_cast<int>(std::floor(std::ilogb(x) / 2.0)));
}

}  // namespace

bool cholesky(const double* matrix, double smallest_pivot, double (&l)[n][n]) noexcept {
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = matrix[n * i + j];
      for (int d = 0; d < j; ++d) sum -= l[i][d] * l[j][d];
      if (i == j && !(sum > 0 && sum > smallest_pivot * matrix[n * i + i])) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  return true;
}

bool InformationFactor::reset(const double* prior) noexcept {
  double l[n][n] = {};
  if (!cholesky(prior, smallest_relative_pivot, l)) return false;
  trace_ = 0;
  prior_log_det_ = 0;
  for (int i = 0; i < n; ++i) {
    unit_[i] = power_of_two_near_root(prior[n * i + i]);
    per_unit_[i] = 1 / unit_[i];
    trace_ += prior[n * i + i] * per_unit_[i] * per_unit_[i];
    prior_log_det_ += 2 * std::log(l[i][i]);
    for (double& entry : w_[i]) entry = 0;
  }
  std::fill(unit_ + n, unit_ + simd::padded_dimension, 0.0);
  for (int j = 0; j < n; ++j) {  // W = L^-1 by columns: L W = I
    w_[j][j] = 1 / l[j][j];
    for (int i = j + 1; i < n; ++i) {
      double sum = 0;
      for (int d = j; d < i; ++d) sum -= l[i][d] * w_[d][j];
      w_[i][j] = sum / l[i][i];
    }
  }
  norm_ = inverse_norm();
  added_ = 0;
  narrow();
  relative_error_ = update_error * norm_ * norm_ * trace_;
  return true;
}

double InformationFactor::add_block(const simd::Kernel& kernel, const double (*rows)[n], int count) noexcept {
  for (int row = 0; row < count; ++row) {
    for (int d = 0; d < n; ++d) trace_ += (rows[row][d] * per_unit_[d]) * (rows[row][d] * per_unit_[d]);
  }
  const double relative_gain = kernel.add_rows(&w_[0][0], &rows[0][0], count, &narrow_[0][0]);
  relative_error_ += count * update_error * norm_ * std::sqrt(trace_);  // |W| before, or earlier: it only decreases
  ++added_;
  if (added_ < norm_interval || added_ % norm_interval == 0) norm_ = inverse_norm();
  return relative_gain;
}

void InformationFactor::narrow() noexcept {
  for (int i = 0; i < n; ++i) {
    for (int d = 0; d < simd::padded_dimension; ++d) narrow_[i][d] = static_cast<float>(w_[i][d]);
  }
}

WhitenedRowBounds InformationFactor::bound_rows(const double* column_max) const noexcept {
  WhitenedRowBounds bounds{0, 0};
  for (int c = 0; c < n; ++c) {
    double sums[2] = {0, 0};  // two independent chains of additions, for speed
    for (int d = 0; d <= c; ++d) {
      constexpr double floor = simd::smallest_entry;
      sums[d % 2] += std::max(std::abs(w_[c][d]), floor) * column_max[d];
      bounds.frobenius += (w_[c][d] * w_[c][d] + floor * floor) * (column_max[d] * column_max[d]);
    }
    bounds.squares += (sums[0] + sums[1]) * (sums[0] + sums[1]);
  }
  return bounds;
}

double InformationFactor::inverse_norm() const noexcept {
  double squares[simd::padded_dimension] = {};  // by columns: independent sums
  for (const auto& row : w_) {
    for (int d = 0; d < simd::padded_dimension; ++d) squares[d] += row[d] * row[d];
  }
  double sum = 0;
  for (int d = 0; d < simd::padded_dimension; ++d) sum += squares[d] * unit_[d] * unit_[d];
  return std::sqrt(sum);
}

}  // namespace maxlogdet
