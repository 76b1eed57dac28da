// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet::sim {

constexpr double pi = 3.14159265358979323846;
constexpr double degrees = 180 / pi;  ///< of a radian
constexpr double radians = pi / 180;  ///< of a degree

}  // namespace maxlogdet::sim
