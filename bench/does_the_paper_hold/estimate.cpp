// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/estimate.hpp"

#include "bench/world/table.hpp"

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

std::string fixed(const Estimate& estimate, int decimals) {
  if (std::isnan(estimate.ci95)) return fixed(estimate.value, decimals);
  return fixed(estimate.value, decimals) + " ± " + fixed(estimate.ci95, decimals);
}

const char* verdict(const Estimate& difference) {
  if (!(std::abs(difference.value) > difference.ci95)) return "·";
  return difference.value < 0 ? "▲" : "▼";
}

std::string claim(const std::vector<double>& ours, const std::vector<double>& theirs) {
  std::vector<double> percents;
  double sum = 0;
  for (const double error : theirs) sum += error / static_cast<double>(theirs.size());
  for (std::size_t i = 0; i < ours.size(); ++i) percents.push_back(100 * (ours[i] - theirs[i]) / sum);
  if (percents.empty()) return "-";
  const Estimate difference = mean_of(percents);
  if (std::isnan(difference.ci95)) return fixed(difference, 1) + " %";  // one run has no interval
  return fixed(difference, 1) + " % " + verdict(difference);
}

}  // namespace maxlogdet::sim
