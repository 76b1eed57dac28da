// SPDX-License-Identifier: MIT
#pragma once

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace maxlogdet::sim {

/// A value and the half width of its 95 % confidence interval.
struct Estimate {
  static constexpr double upper_tail = 0.975;  ///< two-sided intervals end at this quantile

  double value = 0;
  double ci95 = 0;
};

/// Returns the mean of values, and the sum of squared differences to it.
struct Moments {
  explicit Moments(const std::vector<double>& values) {
    mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    for (const double value : values) squares += (value - mean) * (value - mean);
  }

  double mean;
  double squares = 0;
};

/// Returns the mean of independent values, with Student's interval (NaN for fewer than 2).
inline Estimate mean_of(const std::vector<double>& values) {
  const Moments moments(values);
  if (values.size() < 2) return {moments.mean, std::numeric_limits<double>::quiet_NaN()};
  const auto n = static_cast<double>(values.size());
  const double t = quantile(boost::math::students_t(n - 1), Estimate::upper_tail);
  return {moments.mean, t * std::sqrt(moments.squares / (n - 1) / n)};
}

/// Returns the mean of paired errors, ours less theirs, in percent of the mean of theirs.
inline Estimate difference_percent(const std::vector<double>& ours, const std::vector<double>& theirs) {
  const double mean = Moments(theirs).mean;
  std::vector<double> percents;
  for (std::size_t i = 0; i < ours.size(); ++i) percents.push_back(100 * (ours[i] - theirs[i]) / mean);
  return mean_of(percents);
}

/// A statistic of independent observations, and its values with each observation left out.
struct Jackknifed {
  double value = 0;
  std::vector<double> without;

  /// The interval by the jackknife (Efron & Stein 1981).
  Estimate estimate() const {
    const auto n = static_cast<double>(without.size());
    const double z = quantile(boost::math::normal(), Estimate::upper_tail);
    return {value, z * std::sqrt((n - 1) / n * Moments(without).squares)};
  }
};

/// Returns what a difference of errors, ours less theirs, says of ours by its interval: "better", "worse" or "open".
inline const char* verdict(const Estimate& difference) {
  if (!(std::abs(difference.value) > difference.ci95)) return "open";
  return difference.value < 0 ? "better" : "worse";
}

}  // namespace maxlogdet::sim
