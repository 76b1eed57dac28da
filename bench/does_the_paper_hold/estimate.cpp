// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/estimate.hpp"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>

namespace maxlogdet::sim {
namespace {

constexpr double upper_tail = 0.975;  // two-sided 95 % intervals end at this quantile

double plain_mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double squares_about(double centre, const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += (value - centre) * (value - centre);
  return squares;
}

}  // namespace

Estimate mean_of(const std::vector<double>& values) {
  const double mean = plain_mean(values);
  if (values.size() < 2) return {mean, std::numeric_limits<double>::quiet_NaN()};
  const auto n = static_cast<double>(values.size());
  const double t = quantile(boost::math::students_t(n - 1), upper_tail);
  return {mean, t * std::sqrt(squares_about(mean, values) / (n - 1) / n)};
}

Estimate difference_percent(const std::vector<double>& ours, const std::vector<double>& theirs) {
  std::vector<double> percents;
  for (std::size_t i = 0; i < ours.size(); ++i) percents.push_back(100 * (ours[i] - theirs[i]) / plain_mean(theirs));
  return mean_of(percents);
}

Estimate Jackknifed::estimate() const {
  const auto n = static_cast<double>(without.size());
  const double squares = squares_about(plain_mean(without), without);
  return {value, quantile(boost::math::normal(), upper_tail) * std::sqrt((n - 1) / n * squares)};
}

const char* verdict(const Estimate& difference) {
  if (!(std::abs(difference.value) > difference.ci95)) return "open";
  return difference.value < 0 ? "better" : "worse";
}

}  // namespace maxlogdet::sim
