// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

std::vector<std::uint32_t> select_matches(const std::vector<double>& points);
double log_det_with_eigen();
bool helpers_change_nothing(const std::vector<double>& points);
