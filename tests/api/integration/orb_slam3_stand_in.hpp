// SPDX-License-Identifier: MIT
#pragma once

// What the adapter sees of ORB-SLAM3, under its names and with its const and missing const (1.0, 2021). What the
// functions do is for a test to define.

#include "tests/api/integration/sophus_stand_in.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <opencv2/core/core.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace ORB_SLAM3 {

class GeometricCamera {
 public:
  GeometricCamera(std::vector<float> parameters, unsigned int type)
      : mvParameters(std::move(parameters)), mnType(type) {}
  GeometricCamera(const GeometricCamera&) = delete;
  GeometricCamera& operator=(const GeometricCamera&) = delete;
  virtual ~GeometricCamera() = default;
  virtual Eigen::Vector2d project(const Eigen::Vector3d& v3D) = 0;
  float getParameter(const int i) { return mvParameters[static_cast<std::size_t>(i)]; }
  unsigned int GetType() { return mnType; }

  static const unsigned int CAM_PINHOLE = 0;
  static const unsigned int CAM_FISHEYE = 1;

 protected:
  std::vector<float> mvParameters;
  unsigned int mnType;
};

class KeyFrame {
 public:
  Sophus::SE3f GetPose() { return mTcw; }
  bool isBad() { return mbBad; }

  float fx = 458;
  float fy = 457;
  float cx = 367;
  float cy = 248;
  float mbf = 0;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<float> mvuRight;
  std::vector<float> mvScaleFactors;
  GeometricCamera* mpCamera = nullptr;
  GeometricCamera* mpCamera2 = nullptr;

  // Private in the real one.
  Sophus::SE3f mTcw;
  bool mbBad = false;
};

class MapPoint {
 public:
  Eigen::Vector3f GetWorldPos() { return mWorldPos; }
  std::map<KeyFrame*, std::tuple<int, int>> GetObservations() { return mObservations; }
  int Observations() { return nObs; }
  bool isBad() { return mbBad; }

  long unsigned int mnId = 0;
  long int mnFirstKFid = -1;
  int nObs = 0;

  // Private in the real one.
  Eigen::Vector3f mWorldPos = Eigen::Vector3f::Zero();
  std::map<KeyFrame*, std::tuple<int, int>> mObservations;
  bool mbBad = false;
};

class Frame {
 public:
  bool isSet() const { return mbIsSet; }
  Sophus::SE3f GetPose() const { return mTcw; }
  void SetPose(const Sophus::SE3f& Tcw) {
    mTcw = Tcw;
    mbIsSet = true;
  }
  Sophus::SE3f GetRelativePoseTrl() { return mTrl; }

  float mbf = 0;
  int N = 0;
  std::vector<cv::KeyPoint> mvKeys;
  std::vector<cv::KeyPoint> mvKeysRight;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<MapPoint*> mvpMapPoints;
  std::vector<float> mvuRight;
  std::vector<bool> mvbOutlier;
  std::vector<float> mvScaleFactors;
  GeometricCamera* mpCamera = nullptr;
  GeometricCamera* mpCamera2 = nullptr;
  int Nleft = -1;

  // Private in the real one.
  Sophus::SE3f mTcw;
  Sophus::SE3f mTrl;
  bool mbIsSet = false;
};

class Optimizer {
 public:
  int static PoseOptimization(Frame* pFrame);
  int static PoseInertialOptimizationLastKeyFrame(Frame* pFrame, bool bRecInit = false);
};

class Tracking {
 public:
  void TrackLocalMap(bool is_inertial);
  Frame mCurrentFrame;

#include "orb_slam3_member.inc"
};

}  // namespace ORB_SLAM3
