// SPDX-License-Identifier: MIT
#pragma once

// The guide's lines for ORB-SLAM2 where they belong.

#include "orb_slam2_include.inc"
#include "tests/integration/orb_slam2_stand_in.hpp"

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

/// In small: mbTrackInView is set; counts what is in view as visible, and searches.
inline void Tracking::SearchLocalPoints() {
  for (MapPoint* const point : mvpLocalMapPoints) {
    if (point->mbTrackInView && !point->isBad()) point->IncreaseVisible();
  }
  ORBmatcher matcher(0.8F);
  const int th = 1;
#include "orb_slam2_match.inc"
}

}  // namespace ORB_SLAM2
