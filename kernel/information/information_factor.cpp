// SPDX-License-Identifier: MIT
#include "kernel/information/information_factor.hpp"

#include "kernel/base/limits.hpp"
#include "simd/rounding.hpp"

#include <cmath>

namespace maxlogdet {
namespace {

using simd::double_unit_roundoff;

constexpr int n = InformationFactor::n;

// Tolerated asymmetry of a prior, relative to sqrt(M_ii M_jj): the rounding of assembling it in float64.
constexpr double symmetry_tolerance = 1e-8;
// A Cholesky pivot below this share of its diagonal entry is rounding, not information.
constexpr double smallest_relative_pivot = 1e-14;
// The maximum |W_ij|: up to it, W h and the determinant of three rows stay finite in float64 for any float32 block.
constexpr double largest_inverse_entry = 1e10;

// A constant of the error analysis in docs/numerics.md, rounded up.
constexpr double update_error = 192 * double_unit_roundoff;
// The norm of W is recomputed after each of the first blocks, which change it most, and then at this interval.
constexpr std::uint32_t norm_interval = 8;

// The lower Cholesky factor of the symmetric part of a prior; false if it is not safely positive definite.
bool cholesky(const double* prior, double (&l)[n][n]) noexcept {
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (!std::isfinite(prior[n * i + j])) return false;
    }
    if (!(prior[n * i + i] > 0)) return false;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double a = prior[n * i + j];
      const double b = prior[n * j + i];
      if (std::abs(a - b) > symmetry_tolerance * std::sqrt(prior[n * i + i]) * std::sqrt(prior[n * j + j]))
        return false;
      double sum = a / 2 + b / 2;
      for (int d = 0; d < j; ++d) sum -= l[i][d] * l[j][d];
      if (i == j) {
        if (!(sum > smallest_relative_pivot * prior[n * i + i])) return false;
        l[i][i] = std::sqrt(sum);
      } else {
        l[i][j] = sum / l[j][j];
      }
    }
  }
  return true;
}

}  // namespace

bool InformationFactor::reset(const double* prior, const double* added, double roundings) noexcept {
  double information[n * n] = {};
  if (prior == nullptr) {
    for (int i = 0; i < n; ++i) information[n * i + i] = default_prior_information;
    prior = information;
  }
  if (added != nullptr) {
    for (int entry = 0; entry < n * n; ++entry) information[entry] = prior[entry] + added[entry];
    prior = information;
  }
  double l[n][n] = {};
  if (!cholesky(prior, l)) return false;

  trace_ = 0;
  prior_log_det_ = 0;
  for (int i = 0; i < n; ++i) {
    trace_ += prior[n * i + i];
    prior_log_det_ += 2 * std::log(l[i][i]);
    for (double& entry : w_[i]) entry = 0;
  }
  for (int j = 0; j < n; ++j) {  // W = L^-1 by columns: L W = I
    w_[j][j] = 1 / l[j][j];
    for (int i = j + 1; i < n; ++i) {
      double sum = 0;
      for (int d = j; d < i; ++d) sum -= l[i][d] * w_[d][j];
      w_[i][j] = sum / l[i][i];
    }
  }
  for (const auto& row : w_) {
    for (const double entry : row) {
      if (!(std::abs(entry) <= largest_inverse_entry)) return false;
    }
  }
  norm_ = inverse_norm();
  added_ = 0;
  narrow();
  relative_error_ = (update_error + n * roundings * double_unit_roundoff) * norm_ * norm_ * trace_;
  return true;
}

// The bound is derived in docs/numerics.md.
double InformationFactor::determinant_error(const double* prior, const double* added, double roundings) const noexcept {
  double scaled = 0;  // tr D M^-1 D, D^2 the diagonal of M
  for (int d = 0; d < n; ++d) {
    double variance = 0;
    for (const auto& row : w_) variance += row[d] * row[d];
    const double of_prior = prior == nullptr ? default_prior_information : prior[n * d + d];
    scaled += (of_prior + added[n * d + d]) * variance;
  }
  return (update_error + n * roundings * double_unit_roundoff) * scaled;
}

double InformationFactor::add_block(const simd::Kernel& kernel, const double (*rows)[n], int count) noexcept {
  for (int row = 0; row < count; ++row) {
    for (int d = 0; d < n; ++d) trace_ += rows[row][d] * rows[row][d];
  }
  const double relative_gain = kernel.factor.add_rows(&w_[0][0], &rows[0][0], count, &narrow_[0][0]);
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

double InformationFactor::inverse_norm() const noexcept {
  double squares[simd::padded_dimension] = {};  // by columns: independent sums
  for (const auto& row : w_) {
    for (int d = 0; d < simd::padded_dimension; ++d) squares[d] += row[d] * row[d];
  }
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum);
}

}  // namespace maxlogdet
