// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"

#include <array>
#include <vector>

namespace maxlogdet::bench {

/// How well the points of a frame are known, a match each, 3 x 3, world frame, m^2: as triangulated by a stereo pair
/// with the frame's camera, from `distance` m behind its prior pose, with deviations of `sigma` px times the match's
/// own: (J R)^-1 sigma^2 (J R)^-T. NaN for a point that is not in front of that pair.
std::vector<std::array<double, 9>> stereo_covariances(const sim::Frame& frame, double distance, double sigma);

}  // namespace maxlogdet::bench
