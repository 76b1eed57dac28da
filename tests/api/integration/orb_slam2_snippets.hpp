// SPDX-License-Identifier: MIT
#pragma once

// The guide's lines for ORB-SLAM2 where they belong.

#include "orb_slam2_include.inc"
#include "tests/api/integration/orb_slam2_stand_in.hpp"

#include <Eigen/Core>

namespace ORB_SLAM2 {

/// Simplified: matches are there; the call, and the count of inliers on which tracking depends.
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

// Where the optimiser is given the weights.
namespace weighted {

class Optimizer {
 public:
  int static PoseOptimization(Frame* pFrame, const maxlogdet::OrbSlam2* good = nullptr);
};

/// Simplified: g2o's, of stereo.
struct EdgeStereoSE3ProjectXYZOnlyPose {
  void setInformation(const Eigen::Matrix3d& given) { information = given; }
  Eigen::Matrix3d information;
};

class Tracking {
 public:
  void TrackLocalMap(){
#include "orb_slam2_weighted_hook.inc"
  }

  Frame mCurrentFrame;
#include "orb_slam2_member.inc"  // NOLINT(readability-duplicate-include)
};

/// Simplified: what an edge of a stereo match weighs.
inline Eigen::Matrix3d information_of_edge(const Frame* pFrame, std::size_t i, const maxlogdet::OrbSlam2* good) {
  EdgeStereoSE3ProjectXYZOnlyPose edge;
  EdgeStereoSE3ProjectXYZOnlyPose* const e = &edge;
  const float scale = pFrame->mvScaleFactors[static_cast<std::size_t>(pFrame->mvKeysUn[i].octave)];
  const Eigen::Matrix3d Info = Eigen::Matrix3d::Identity() / (scale * scale);
  e->setInformation(Info);
#include "orb_slam2_weight.inc"
  return e->information;
}

}  // namespace weighted
}  // namespace ORB_SLAM2
