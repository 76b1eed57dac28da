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

/// Returns the mean of paired errors, ours less theirs, in percent of the mean of theirs.
Estimate difference_percent(const std::vector<double>& ours, const std::vector<double>& theirs);

/// A statistic of independent observations, and its values with each observation left out.
struct Jackknifed {
  double value = 0;
  std::vector<double> without;

  /// The interval by the jackknife (Efron & Stein 1981).
  Estimate estimate() const;
};

/// Returns what a difference of errors, ours less theirs, says of ours by its interval: "better", "worse" or "open".
const char* verdict(const Estimate& difference);

}  // namespace maxlogdet::sim
