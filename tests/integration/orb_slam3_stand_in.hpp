// SPDX-License-Identifier: MIT
#pragma once

// What the guide's code sees of ORB-SLAM3, under its names (1.0, 2021).

#include "tests/integration/opencv_stand_in.hpp"
#include "tests/integration/sophus_stand_in.hpp"

#include <Eigen/Core>
#include <vector>

namespace ORB_SLAM3 {

class GeometricCamera {
 public:
  GeometricCamera() = default;
  GeometricCamera(const GeometricCamera&) = delete;
  GeometricCamera& operator=(const GeometricCamera&) = delete;
  virtual ~GeometricCamera() = default;
  virtual Eigen::Vector2d project(const Eigen::Vector3d& v3D) = 0;
};

class MapPoint {
 public:
  Eigen::Vector3f GetWorldPos() const { return mWorldPos; }
  bool isBad() const { return mbBad; }

  // Hidden in the real one.
  Eigen::Vector3f mWorldPos = Eigen::Vector3f::Zero();
  bool mbBad = false;
};

class Frame {
 public:
  Sophus::SE3f GetPose() const { return mTcw; }
  void SetPose(const Sophus::SE3f& Tcw) { mTcw = Tcw; }

  static float fx;
  static float fy;
  static float cx;
  static float cy;
  float mbf = 0;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<float> mvuRight;
  std::vector<MapPoint*> mvpMapPoints;
  std::vector<bool> mvbOutlier;
  std::vector<float> mvInvLevelSigma2;
  GeometricCamera* mpCamera = nullptr;
  GeometricCamera* mpCamera2 = nullptr;

 private:
  Sophus::SE3f mTcw;
};

class Optimizer {
 public:
  static int PoseInertialOptimizationLastKeyFrame(Frame* pFrame, bool bRecInit = false);
};

class Tracking {
 public:
  void TrackLocalMap();
  Frame mCurrentFrame;

 private:
#include "orb_slam2_member.inc"
};

}  // namespace ORB_SLAM3
