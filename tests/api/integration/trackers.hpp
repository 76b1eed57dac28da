// SPDX-License-Identifier: MIT
#pragma once

// What the adapters see of ORB-SLAM2 (master, 2017) and of ORB-SLAM3 (1.0, 2021), under its names and with its const
// and missing const, and the lines of docs/trackers.md where they belong. Pose, position and flags are private in some
// of the real classes. What the optimisers do is for a test to define.

#include <maxlogdet/adapters/orb_slam3.hpp>
#include <maxlogdet/adapters/vins_fusion.hpp>
#include "orb_slam2_include.inc"

#include <Eigen/Core>
#include <cstddef>
#include <list>
#include <map>
#include <opencv2/core/core.hpp>
#include <set>
#include <sophus/se3.hpp>
#include <tuple>
#include <utility>
#include <vector>

// What both trackers have.
namespace orb_slam {

template <class Pose>
struct KeyFrame {
  bool isBad() { return mbBad; }

  float fx = 458;
  float fy = 457;
  float cx = 367;
  float cy = 248;
  float mbf = 0;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<float> mvuRight;
  std::vector<float> mvScaleFactors;
  Pose mTcw;
  bool mbBad = false;
};

/// `Place`: where a keyframe sees the point.
template <class KeyFrame, class Position, class Place>
struct MapPoint {
  Position GetWorldPos() { return mWorldPos; }
  std::map<KeyFrame*, Place> GetObservations() { return mObservations; }
  int Observations() { return nObs; }
  bool isBad() { return false; }
  void IncreaseFound() { ++mnFound; }

  long unsigned int mnId = 0;
  long int mnFirstKFid = -1;
  int nObs = 0;
  int mnFound = 1;
  std::map<KeyFrame*, Place> mObservations;
  Position mWorldPos;
};

template <class MapPoint>
struct Frame {
  float mbf = 0;
  std::vector<cv::KeyPoint> mvKeysUn;
  std::vector<float> mvuRight;
  std::vector<MapPoint*> mvpMapPoints;
  std::vector<bool> mvbOutlier;
  std::vector<float> mvScaleFactors;
};

}  // namespace orb_slam

namespace ORB_SLAM2 {

struct KeyFrame : orb_slam::KeyFrame<cv::Mat> {
  cv::Mat GetPose() { return mTcw.clone(); }
};
using MapPoint = orb_slam::MapPoint<KeyFrame, cv::Mat, std::size_t>;

struct Frame : orb_slam::Frame<MapPoint> {
  void SetPose(cv::Mat Tcw) { mTcw = Tcw.clone(); }

  static float fx;
  static float fy;
  static float cx;
  static float cy;
  cv::Mat mTcw;
};

class Optimizer {
 public:
  int static PoseOptimization(Frame* pFrame);
};

class Tracking {
 public:
  /// Simplified: matches are there; the call, and the count of inliers on which tracking depends.
  bool TrackLocalMap() {
#include "orb_slam2_hook.inc"
    mnMatchesInliers = 0;
    for (std::size_t i = 0; i < mCurrentFrame.mvpMapPoints.size(); ++i) {
      if (mCurrentFrame.mvpMapPoints[i] == nullptr || mCurrentFrame.mvbOutlier[i]) continue;
      mCurrentFrame.mvpMapPoints[i]->IncreaseFound();
      ++mnMatchesInliers;
    }
    return mnMatchesInliers >= 30;
  }

  Frame mCurrentFrame;
  int mnMatchesInliers = 0;
#include "orb_slam2_member.inc"
};

// Where the optimiser is given the weights.
namespace weighted {

/// Simplified: g2o's, of stereo.
struct EdgeStereoSE3ProjectXYZOnlyPose {
  void setInformation(const Eigen::Matrix3d& given) { information = given; }
  Eigen::Matrix3d information;
};

/// Simplified: makes the edges of stereo matches, by slot, and optimises nothing.
struct Optimizer {
  int static PoseOptimization(Frame* pFrame, const maxlogdet::OrbSlam2* good = nullptr) {
    edges().clear();
    for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
      if (pFrame->mvpMapPoints[i] == nullptr || pFrame->mvuRight[i] < 0) continue;
      EdgeStereoSE3ProjectXYZOnlyPose* const e = &edges()[i];
      const float scale = pFrame->mvScaleFactors[static_cast<std::size_t>(pFrame->mvKeysUn[i].octave)];
      const Eigen::Matrix3d Info = Eigen::Matrix3d::Identity() / (scale * scale);
      e->setInformation(Info);
#include "orb_slam2_weight.inc"
    }
    return 0;
  }
  static std::map<std::size_t, EdgeStereoSE3ProjectXYZOnlyPose>& edges() {
    static std::map<std::size_t, EdgeStereoSE3ProjectXYZOnlyPose> all;
    return all;
  }
};

struct Tracking {
  void TrackLocalMap(){
#include "orb_slam2_weighted_hook.inc"
  }

  Frame mCurrentFrame;
#include "orb_slam2_member.inc"  // NOLINT(readability-duplicate-include)
};

}  // namespace weighted
}  // namespace ORB_SLAM2

namespace ORB_SLAM3 {

/// Simplified: the real one has a class for each model.
class GeometricCamera {
 public:
  float getParameter(const int i) { return mvParameters[static_cast<std::size_t>(i)]; }
  unsigned int GetType() { return mnType; }

  std::vector<float> mvParameters;
  unsigned int mnType;  ///< 0: pinhole, 1: Kannala and Brandt's
};

struct KeyFrame : orb_slam::KeyFrame<Sophus::SE3f> {
  Sophus::SE3f GetPose() { return mTcw; }

  GeometricCamera* mpCamera = nullptr;
  GeometricCamera* mpCamera2 = nullptr;
};
using MapPoint = orb_slam::MapPoint<KeyFrame, Eigen::Vector3f, std::tuple<int, int>>;

struct Frame : orb_slam::Frame<MapPoint> {
  bool isSet() const { return mbIsSet; }
  Sophus::SE3f GetPose() const { return mTcw; }
  void SetPose(const Sophus::SE3f& Tcw) {
    mTcw = Tcw;
    mbIsSet = true;
  }
  Sophus::SE3f GetRelativePoseTrl() { return mTrl; }

  std::vector<cv::KeyPoint> mvKeys;
  std::vector<cv::KeyPoint> mvKeysRight;
  GeometricCamera* mpCamera = nullptr;
  GeometricCamera* mpCamera2 = nullptr;
  int Nleft = -1;
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
  /// Simplified: the call.
  void TrackLocalMap() {
    if (!is_inertial) {
#include "orb_slam3_hook.inc"
    } else {
#include "orb_slam3_inertial_hook.inc"
    }
  }

  bool is_inertial = false;
  Frame mCurrentFrame;
#include "orb_slam3_member.inc"
};

}  // namespace ORB_SLAM3

// VINS-Fusion.

constexpr int WINDOW_SIZE = 10;

struct FeaturePerFrame {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< (x / z, y / z, 1) in the camera frame
};

struct FeaturePerId {
  FeaturePerId(int _feature_id, int _start_frame) : feature_id(_feature_id), start_frame(_start_frame) {}

  const int feature_id;
  int start_frame;
  std::vector<FeaturePerFrame> feature_per_frame;
  int used_num = 0;
  double estimated_depth = -1;
  int solve_flag = 0;  ///< 0: depth not optimised yet, 1: optimised, 2: failed
};

struct FeatureManager {
  std::list<FeaturePerId> feature;
};

class Estimator {
 public:
  /// Simplified: which features get factors, and which place each of them has.
  void optimization() {
#include "vins_fusion_ask.inc"
    int feature_index = -1;
    for (auto& it_per_id : f_manager.feature) {
      it_per_id.used_num = static_cast<int>(it_per_id.feature_per_frame.size());
      if (it_per_id.used_num < 4) continue;
      ++feature_index;
#include "vins_fusion_hook.inc"
      added.emplace_back(it_per_id.feature_id, feature_index);
    }
  }

  /// Simplified: as if all reprojection errors were too large.
  void outliersRejection(std::set<int>& removeIndex) {
    for (auto& it_per_id : f_manager.feature) {
      it_per_id.used_num = static_cast<int>(it_per_id.feature_per_frame.size());
      if (it_per_id.used_num < 4) continue;
#include "vins_fusion_hook.inc"  // NOLINT(readability-duplicate-include): the page has it in two places
      removeIndex.insert(it_per_id.feature_id);
    }
  }

  int frame_count = 0;
  FeatureManager f_manager;
  Eigen::Vector3d Ps[WINDOW_SIZE + 1];
  Eigen::Matrix3d Rs[WINDOW_SIZE + 1];
  Eigen::Matrix3d ric[2];
  Eigen::Vector3d tic[2];

  /// Not in the real one: features that the problem was made of, with their places in para_Feature.
  std::vector<std::pair<int, int>> added;

#include "vins_fusion_member.inc"
};
