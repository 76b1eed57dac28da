// SPDX-License-Identifier: MIT
#include "bench/world/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <limits>

namespace maxlogdet::sim {
namespace {

// Two-sided 95 % intervals end at this quantile.
constexpr double upper_tail = 0.975;

double normal_quantile() { return quantile(boost::math::normal(), upper_tail); }

double student_quantile(std::size_t freedom) {
  return quantile(boost::math::students_t(static_cast<double>(freedom)), upper_tail);
}

struct Moments {
  double mean;
  double deviation;
};

Moments moments_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += value;
  const double mean = sum / n;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (n - 1))};
}

}  // namespace

Estimate mean_of(const std::vector<double>& values) {
  const Moments moments = moments_of(values);
  if (values.size() < 2) return {moments.mean, std::numeric_limits<double>::quiet_NaN()};
  const double t = student_quantile(values.size() - 1);
  return {moments.mean, t * moments.deviation / std::sqrt(static_cast<double>(values.size()))};
}

Estimate rms_of(const std::vector<double>& errors) {
  std::vector<double> squares;
  for (const double error : errors) squares.push_back(error * error);
  const Moments moments = moments_of(squares);
  const double rms = std::sqrt(moments.mean);
  const double deviation_of_mean = moments.deviation / std::sqrt(static_cast<double>(errors.size()));
  return {rms, normal_quantile() * deviation_of_mean / (2 * rms)};
}

double jackknife_ci95(const std::vector<double>& without) {
  const auto n = static_cast<double>(without.size());
  double mean = 0;
  for (const double value : without) mean += value / n;
  double squares = 0;
  for (const double value : without) squares += (value - mean) * (value - mean);
  return normal_quantile() * std::sqrt((n - 1) / n * squares);
}

Estimate rms_change_percent(const std::vector<double>& ours, const std::vector<double>& theirs) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  double our_sum = 0, their_sum = 0;
  for (const double error : ours) our_sum += error * error;
  for (const double error : theirs) their_sum += error * error;
  if (ours.empty() || !(their_sum > 0)) return {nan, nan};
  std::vector<double> without;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const double our_rest = our_sum - ours[i] * ours[i], their_rest = their_sum - theirs[i] * theirs[i];
    without.push_back(100 * std::sqrt(std::max(our_rest, 0.0) / their_rest) - 100);
  }
  return {100 * std::sqrt(our_sum / their_sum) - 100, ours.size() < 2 ? nan : jackknife_ci95(without)};
}

double quantile_of(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double share = at - static_cast<double>(below);
  if (share == 0 || values[below] == values[above]) return values[below];  // also of infinite ones
  return values[below] + share * (values[above] - values[below]);
}

}  // namespace maxlogdet::sim
