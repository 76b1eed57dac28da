// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace maxlogdet::sim {

/// Returns a quantile, linear between order statistics (R's type 7), of at least one value.
double quantile_of(std::vector<double> values, double q);

}  // namespace maxlogdet::sim
