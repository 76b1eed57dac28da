// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A value and the half width of its 95 % confidence interval.
struct Estimate {
  double value = 0;
  double ci95 = 0;
};

/// Returns the mean of independent values, with Student's interval (NaN for fewer than 2).
Estimate mean_of(const std::vector<double>& values);

/// Returns the root mean square of independent errors; the interval is the mean square's, by the delta method:
/// 1.96 s(e^2) / sqrt(n) / (2 rms).
Estimate rms_of(const std::vector<double>& errors);

/// Returns the half width of the 95 % interval of a statistic by the jackknife, from its values with one observation
/// left out (Efron & Stein 1981).
double jackknife_ci95(const std::vector<double>& without);

/// Returns a text like "0.123 ± 0.004".
std::string fixed(const Estimate& estimate, int decimals);

/// Returns the verdict on a difference of errors, ours less theirs, by its 95 % interval: "▲" ours are lower, "▼"
/// higher, "·" not significant.
const char* verdict(const Estimate& difference);

/// Returns the difference of paired errors, ours less theirs in percent of the mean of theirs, with its 95 % interval
/// and verdict; "-" without errors.
std::string claim(const std::vector<double>& ours, const std::vector<double>& theirs);

}  // namespace maxlogdet::sim
