// SPDX-License-Identifier: MIT
#pragma once

// The guide's lines for ORB-SLAM3 where they belong.

#include <maxlogdet/adapters/orb_slam3.hpp>

#include "tests/api/integration/orb_slam3_stand_in.hpp"

namespace ORB_SLAM3 {

inline void Tracking::TrackLocalMap(bool is_inertial) {
  if (!is_inertial) {
#include "orb_slam3_hook.inc"
  } else {
#include "orb_slam3_inertial_hook.inc"
  }
}

}  // namespace ORB_SLAM3
