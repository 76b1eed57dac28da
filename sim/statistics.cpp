// SPDX-License-Identifier: MIT
#include "sim/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double normal_975 = 1.959964;

// 97.5 % quantiles of Student's t with 1, 2, ... 30 degrees of freedom.
constexpr double student_975[] = {12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281,
                                  2.2010,  2.1788, 2.1604, 2.1448, 2.1314, 2.1199, 2.1098, 2.1009, 2.0930, 2.0860,
                                  2.0796,  2.0739, 2.0687, 2.0639, 2.0595, 2.0555, 2.0518, 2.0484, 2.0452, 2.0423};

// Beyond the table: the first terms of the quantile's expansion in 1 / freedom (Cornish & Fisher 1938), good to 1e-4.
double student_quantile(std::size_t freedom) {
  if (freedom <= std::size(student_975)) return student_975[freedom - 1];
  constexpr double z = normal_975, z2 = z * z;
  const auto n = static_cast<double>(freedom);
  return z + z * (z2 + 1) / (4 * n) + z * (5 * z2 * z2 + 16 * z2 + 3) / (96 * n * n);
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
  const double ci95 = normal_975 * moments.deviation / std::sqrt(static_cast<double>(errors.size())) / (2 * rms);
  return {rms, ci95};
}

double jackknife_ci95(const std::vector<double>& without) {
  const auto n = static_cast<double>(without.size());
  double mean = 0;
  for (const double value : without) mean += value / n;
  double squares = 0;
  for (const double value : without) squares += (value - mean) * (value - mean);
  return normal_975 * std::sqrt((n - 1) / n * squares);
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
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace maxlogdet::sim
