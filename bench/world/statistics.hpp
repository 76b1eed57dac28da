// SPDX-License-Identifier: MIT
#pragma once

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

/// Returns the change of the root mean square of paired errors, in percent of that of `theirs`; the interval is the
/// jackknife's. NaN without a pair, or where theirs is 0.
Estimate rms_change_percent(const std::vector<double>& ours, const std::vector<double>& theirs);

/// Returns a quantile, linear between order statistics (R's type 7), of at least one value.
double quantile_of(std::vector<double> values, double q);

}  // namespace maxlogdet::sim
