// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

/// What the tracker of README.md does with a frame at the identity, in which every fifth match is wrong.
struct Tracked {
  std::size_t selected = 0, outliers = 0;
};
Tracked track_frame(const std::vector<double>& points);
double log_det_with_eigen();
bool helpers_change_nothing(const std::vector<double>& points);
