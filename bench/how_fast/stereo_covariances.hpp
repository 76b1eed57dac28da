// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <array>
#include <vector>

namespace maxlogdet::bench {

/// Covariances of a frame's points, one per match, 3 x 3, world frame, m^2, if a stereo pair with the frame's camera
/// triangulated them from `distance` m behind its prior pose with standard deviations of `sigma` px times the match's
/// own: (J R)^-1 sigma^2 (J R)^-T. NaN for a point that is not in front of that pair.
std::vector<std::array<double, 9>> stereo_covariances(const sim::Frame& frame, double distance, double sigma);

}  // namespace maxlogdet::bench
