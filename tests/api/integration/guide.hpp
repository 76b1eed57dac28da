// SPDX-License-Identifier: MIT
#pragma once

// The code of docs/guide.md and of docs/trackers.md, where it would stand in a tracker: in one of its own types, and in
// what the adapters see of ORB-SLAM2 (master, 2017), ORB-SLAM3 (1.0, 2021) and VINS-Fusion, under their names and with
// their const and missing const. Pose, position and flags are private in some of the real classes. What the optimisers
// do is for a test to define.

#include <maxlogdet/adapters/orb_slam3.hpp>
#include <maxlogdet/adapters/vins_fusion.hpp>
#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>
#include <maxlogdet/opencv.hpp>
#include "examples/priors.hpp"
#include "orb_slam2_include.inc"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <list>
#include <opencv2/core/core.hpp>
#include <set>
#include <sophus/se3.hpp>
#include <utility>
#include <vector>

/// The types of a tracker that nobody else knows.
namespace own {

/// World to camera: 3 x 3 row-major and 3 entries.
struct Pose {
  float rotation[9];
  float translation[3];
};

struct Point {
  void copy_to(double* to) const {
    for (int d = 0; d < 3; ++d) to[d] = p[d];
  }
  Eigen::Vector3d p;
};

}  // namespace own

namespace maxlogdet {
template <>
struct PoseTraits<own::Pose> {
  static RigidTransform convert(const own::Pose& T) { return RigidTransform::from(T.rotation, T.translation); }
};
template <>
struct PointTraits<own::Point> {
  static void read_three(const own::Point& p, double* to) { p.copy_to(to); }
};
}  // namespace maxlogdet

namespace guide {

struct Observation {
  Eigen::Isometry3d T_cw;
  double sigma;
  bool is_stereo;
};

/// A match as a tracker with an octave and a right column, or a depth, has it.
struct Match {
  Eigen::Vector3d point;
  cv::Point2f keypoint;
  int octave;
  float u_right;
  float depth;
  std::uint32_t slot;
  std::vector<Observation> observations;
};

/// `good`, which has a start() as GoodFeatures, starts four times.
template <class Good, class Isometry>
void start_by_all(Good& good, const maxlogdet::Camera& camera, const Isometry& isometry, const float* rows,
                  const double* columns, const double* R, const double* t) {
#include "poses.inc"
}

inline void add_stereo(maxlogdet::GoodFeatures& good, const Match& m) {
#include "stereo.inc"
}

/// Starts a frame on a rig, and adds what its second camera has seen.
template <class Pose>
void add_of_rig(maxlogdet::GoodFeatures& good, const double (&of_pinhole)[4], const double* k, const double* p,
                const Pose& T_lb, const Pose& T_rb, const Pose& T_bw, maxlogdet::FeatureMatch match) {
  const double fx = of_pinhole[0], fy = of_pinhole[1], cx = of_pinhole[2], cy = of_pinhole[3];
#include "cameras.inc"
  good.add(match);
  good.select(1);  // while the rig is there
}

/// As the first program of the guide has it, with the number of the map point.
struct NumberedMatch {
  double point[3];
  double pixel[2];
  double sigma;
  std::int64_t point_id;
};

/// `good`, which has a record() and an add() as GoodFeatures, adds one match.
template <class Good>
void add_to_recording(Good& good, const NumberedMatch& m) {
#include "record.inc"
}

inline bool add_covariance(const maxlogdet::PinholeCamera& pinhole, const Match& m, maxlogdet::FeatureMatch& match,
                           double* covariance) {
#include "covariances.inc"
  return match.covariance != nullptr;
}

inline maxlogdet::Selection select_by_options(maxlogdet::GoodFeatures& good,
                                              const std::vector<std::uint32_t>& keyframes, std::size_t keyframe_count) {
#include "options.inc"
  return selection;
}

}  // namespace guide

// What both trackers have.
namespace orb_slam {

template <class Position>
struct MapPoint {
  Position GetWorldPos() { return mWorldPos; }

  long unsigned int mnId = 0;
  long int mnFirstKFid = -1;
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

using MapPoint = orb_slam::MapPoint<cv::Mat>;

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
  Frame mCurrentFrame;
#include "orb_slam2_member.inc"

  /// Simplified: the call; and the other one that the page offers.
  void TrackLocalMap() {
#include "orb_slam2_hook.inc"
  }
  void AlignLocalMap() {
#include "orb_slam2_align.inc"
  }
};

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

using MapPoint = orb_slam::MapPoint<Eigen::Vector3f>;

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
};

class Tracking {
 public:
  Frame mCurrentFrame;
#include "orb_slam3_member.inc"

  /// Simplified: the call; and the other one that the page offers.
  void TrackLocalMap() {
#include "orb_slam2_hook.inc"  // NOLINT(readability-duplicate-include): the page has it for both trackers
  }
  void AlignLocalMap() {
#include "orb_slam2_align.inc"  // NOLINT(readability-duplicate-include)
  }
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
