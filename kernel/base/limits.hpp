// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

namespace maxlogdet {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr float float_infinity = std::numeric_limits<float>::infinity();

}  // namespace maxlogdet
