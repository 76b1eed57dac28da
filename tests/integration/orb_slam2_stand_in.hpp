// SPDX-License-Identifier: MIT
#pragma once

// What the guide's code sees of ORB-SLAM2, under its names (master, 2017). What the functions do is for a test to
// define.

#include "tests/integration/opencv_stand_in.hpp"

#include <cstddef>
#include <vector>

namespace ORB_SLAM2 {

class MapPoint {
 public:
  cv::Mat GetWorldPos() const { return mWorldPos.clone(); }
  bool isBad() const { return mbBad; }
  int Observations() const { return nObs; }
  void IncreaseVisible(int n = 1) { mnVisible += n; }
  void IncreaseFound(int n = 1) { mnFound += n; }

  bool mbTrackInView = false;
  int mnTrackScaleLevel = 0;
  int nObs = 2;

  // Hidden in the real one.
  cv::Mat mWorldPos;
  bool mbBad = false;
  int mnVisible = 1;
  int mnFound = 1;
};

class Frame {
 public:
  void SetPose(const cv::Mat& Tcw) { mTcw = Tcw.clone(); }

  static float fx;
  static float fy;
  static float cx;
  static float cy;
  float mbf = 0;
  int N = 0;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<float> mvuRight;
  std::vector<MapPoint*> mvpMapPoints;
  std::vector<bool> mvbOutlier;
  cv::Mat mTcw;
  std::vector<float> mvScaleFactors;
  std::vector<float> mvInvLevelSigma2;
};

class Optimizer {
 public:
  static int PoseOptimization(Frame* pFrame);
};

class ORBmatcher {
 public:
  int SearchByProjection(Frame& F, const std::vector<MapPoint*>& vpMapPoints, float th);
};

class Tracking {
 public:
  bool TrackLocalMap();

  Frame mCurrentFrame;
  int mnMatchesInliers = 0;

 private:
#include "orb_slam2_member.inc"
};

}  // namespace ORB_SLAM2
