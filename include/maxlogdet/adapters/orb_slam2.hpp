// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/orb_slam.hpp>

// ORB-SLAM2. In its CMakeLists.txt add
//
//   find_package(maxlogdet REQUIRED)
//   target_link_libraries(${PROJECT_NAME} maxlogdet::maxlogdet)
//
// in include/Tracking.h include this header and add a member to the class Tracking
//
//   maxlogdet::OrbSlam2 mGoodFeatures{200};
//
// and in Tracking::TrackLocalMap replace Optimizer::PoseOptimization(&mCurrentFrame) by
//
//   mGoodFeatures.optimize(mCurrentFrame, Optimizer::PoseOptimization);
//
// All other calls of PoseOptimization (TrackWithMotionModel, TrackReferenceKeyFrame, Relocalization) stay as they are:
// they reject outliers among few matches.

namespace maxlogdet {

/// Selection in ORB-SLAM2's tracking thread, monocular, stereo and RGB-D (whose depth is a virtual right column there).
class OrbSlam2 : public OrbSlamHook {
 public:
  /// `budget`: how many matches to optimise with. `capacity`: maximum number of matches of a frame; a frame with
  /// more is optimised with all.
  explicit OrbSlam2(std::size_t budget = 200, std::size_t capacity = 10000) : OrbSlamHook(budget, capacity) {}

  /// Calls pose_optimization(&frame) with the selected matches only; returns the number of inliers among all. With few
  /// matches, and on any error, it is called with all; cost().status says why.
  template <class Frame, class Optimize>
  int optimize(Frame& frame, const Optimize& pose_optimization) {
    return optimize_selected(
        frame, pose_optimization, [&] { gather(frame); }, [](const Frame& optimized) { return pose_of(optimized); });
  }

 private:
  template <class Frame>
  void gather(const Frame& frame) {
    forget_old_covariances();
    features.start(Camera(frame.fx, frame.fy, frame.cx, frame.cy, frame.mbf), pose_of(frame),
                   frame.mbf > 0 ? DepthCue::stereo : DepthCue::none);
    for_each_match(frame.mvpMapPoints, [&](std::size_t slot) { add_match(frame, *frame.mvpMapPoints[slot], slot); });
  }

  template <class Frame, class MapPoint>
  void add_match(const Frame& frame, MapPoint& point, std::size_t slot) {
    FeatureMatch match;
    set_point(point, match);
    set_numbers(point, match);
    const auto& key = frame.mvKeysUn[slot];
    match.id = static_cast<std::uint32_t>(slot);
    match.measured[0] = key.pt.x;
    match.measured[1] = key.pt.y;
    if (frame.mvuRight[slot] >= 0) match.depth_cue = frame.mvuRight[slot];
    match.sigma = frame.mvScaleFactors[static_cast<std::size_t>(key.octave)];
    features.add(match);
  }

  template <class MapPoint>
  void set_point(MapPoint& point, FeatureMatch& match) {
    const auto p_w = point.GetWorldPos();  // cv::Mat, 3 x 1, CV_32F
    for (int i = 0; i < 3; ++i) match.point[i] = p_w.template at<float>(i);
    if (!use_covariances) return;
    match.covariance = covariance_of(point, match.point, [&](PointCovariance& of_point) {
      for (const auto& observation : point.GetObservations()) {
        auto& keyframe = *observation.first;
        const std::size_t i = observation.second;
        if (keyframe.isBad()) continue;
        const auto T_cw = keyframe.GetPose();
        const auto octave = static_cast<std::size_t>(keyframe.mvKeysUn[i].octave);
        of_point.observe({keyframe.fx, keyframe.fy, keyframe.cx, keyframe.cy, keyframe.mbf},
                         RigidTransform(T_cw.template ptr<float>()), keyframe.mvScaleFactors[octave],
                         keyframe.mvuRight[i] >= 0);
      }
    });
  }

  template <class Frame>
  static RigidTransform pose_of(const Frame& frame) {
    return RigidTransform(frame.mTcw.template ptr<float>());  // 4 x 4, CV_32F; null before the first pose
  }
};

}  // namespace maxlogdet
