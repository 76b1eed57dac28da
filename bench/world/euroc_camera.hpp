// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>

namespace maxlogdet::sim {

/// Cam0 of the EuRoC MAV dataset, without its distortion and without a second camera.
constexpr PinholeCamera euroc_camera{458.654, 457.296, 367.215, 248.375};
constexpr int euroc_width = 752;   ///< px
constexpr int euroc_height = 480;  ///< px

}  // namespace maxlogdet::sim
