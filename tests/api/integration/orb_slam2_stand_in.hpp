// SPDX-License-Identifier: MIT
#pragma once

// What the adapter sees of ORB-SLAM2, under its names and with its const and missing const (master, 2017). What the
// functions do is for a test to define.

#include <cstddef>
#include <map>
#include <opencv2/core/core.hpp>
#include <vector>

namespace ORB_SLAM2 {

class KeyFrame {
 public:
  cv::Mat GetPose() { return Tcw.clone(); }
  bool isBad() { return mbBad; }

  float fx = 458;
  float fy = 457;
  float cx = 367;
  float cy = 248;
  float mbf = 0;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<float> mvuRight;
  std::vector<float> mvScaleFactors;

  // Private in the real one.
  cv::Mat Tcw;
  bool mbBad = false;
};

class MapPoint {
 public:
  cv::Mat GetWorldPos() { return mWorldPos.clone(); }
  std::map<KeyFrame*, std::size_t> GetObservations() { return mObservations; }
  int Observations() { return nObs; }
  bool isBad() { return mbBad; }
  void IncreaseFound(int n = 1) { mnFound += n; }

  long unsigned int mnId = 0;
  long int mnFirstKFid = -1;
  int nObs = 0;

  // Private in the real one.
  std::map<KeyFrame*, std::size_t> mObservations;
  cv::Mat mWorldPos;
  bool mbBad = false;
  int mnFound = 1;
};

class Frame {
 public:
  void SetPose(cv::Mat Tcw) { mTcw = Tcw.clone(); }

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
};

class Optimizer {
 public:
  int static PoseOptimization(Frame* pFrame);
};

class Tracking {
 public:
  bool TrackLocalMap();

  Frame mCurrentFrame;
  int mnMatchesInliers = 0;

#include "orb_slam2_member.inc"
};

}  // namespace ORB_SLAM2
