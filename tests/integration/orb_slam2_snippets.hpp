// SPDX-License-Identifier: MIT
#pragma once

// The guide's code for ORB-SLAM2 where it belongs.

#include "good_features.inc"

#include "tests/integration/orb_slam2_stand_in.hpp"

#include "optimize_with_selected.inc"
#include "point_covariance.inc"

#include "orb_slam2_blocks.inc"

#include "active_features.inc"
#include "orb_slam2_active.inc"

namespace ORB_SLAM2 {

/// In small: matches are there; the call, and the count of inliers on which tracking depends.
inline bool Tracking::TrackLocalMap() {
#include "orb_slam2_hook.inc"
  mnMatchesInliers = 0;
  for (std::size_t i = 0; i < mCurrentFrame.mvpMapPoints.size(); ++i) {
    if (mCurrentFrame.mvpMapPoints[i] == nullptr || mCurrentFrame.mvbOutlier[i]) continue;
    mCurrentFrame.mvpMapPoints[i]->IncreaseFound();
    ++mnMatchesInliers;
  }
  return mnMatchesInliers >= 30;
}

}  // namespace ORB_SLAM2
