// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace maxlogdet::sim {

/// A value and the half width of its 95 % confidence interval.
struct Estimate {
  double value = 0;
  double ci95 = 0;
};

/// Mean of independent values, with Student's interval (NaN for fewer than 2).
Estimate mean_of(const std::vector<double>& values);

/// Root mean square of independent errors; the interval is the mean square's, by the delta method:
/// 1.96 s(e^2) / sqrt(n) / (2 rms).
Estimate rms_of(const std::vector<double>& errors);

/// Quantile, linear between order statistics (R's type 7); at least one value.
double quantile_of(std::vector<double> values, double q);

}  // namespace maxlogdet::sim
