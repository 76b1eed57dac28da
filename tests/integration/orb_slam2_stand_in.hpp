// SPDX-License-Identifier: MIT
#pragma once

// What the guide's code sees of ORB-SLAM2, under its names (master, 2017). What the functions do is for a test to
// define.

#include "tests/integration/opencv_stand_in.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <map>
#include <mutex>
#include <vector>

namespace ORB_SLAM2 {

class KeyFrame {
 public:
  cv::Mat GetPose() const { return Tcw.clone(); }
  bool isBad() const { return mbBad; }

  float fx = 458;
  float fy = 457;
  float cx = 367;
  float cy = 248;
  float mbf = 0;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<float> mvuRight;
  std::vector<float> mvInvLevelSigma2;

  // Hidden in the real one.
  cv::Mat Tcw;
  bool mbBad = false;
};

class MapPoint {
 public:
  std::map<KeyFrame*, std::size_t> GetObservations() const { return mObservations; }
  cv::Mat GetWorldPos() const { return mWorldPos.clone(); }
  bool isBad() const { return mbBad; }
  int Observations() const { return nObs; }
  void IncreaseVisible(int n = 1) { mnVisible += n; }
  void IncreaseFound(int n = 1) { mnFound += n; }

  bool mbTrackInView = false;
  int mnTrackScaleLevel = 0;
  int nObs = 2;

  // clang-format off
#include "orb_slam2_map_point.inc"
  // clang-format on

  // Hidden in the real one.
  std::mutex mMutexPos;
  std::map<KeyFrame*, std::size_t> mObservations;
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
