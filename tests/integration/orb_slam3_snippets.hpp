// SPDX-License-Identifier: MIT
#pragma once

// The guide's code for ORB-SLAM3 where it belongs.

#include "good_features.inc"

#include "tests/integration/orb_slam3_stand_in.hpp"

#include "optimize_with_selected.inc"
#include "orb_slam3_blocks.inc"

namespace ORB_SLAM3 {

inline void Tracking::TrackLocalMap() {
#include "orb_slam3_hook.inc"
}

}  // namespace ORB_SLAM3
