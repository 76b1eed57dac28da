// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/orb_slam.hpp>
#include <maxlogdet/eigen.hpp>

#include <tuple>

// ORB-SLAM3. In its CMakeLists.txt add
//
//   find_package(maxlogdet REQUIRED)
//   target_link_libraries(${PROJECT_NAME} maxlogdet::maxlogdet)
//
// in include/Tracking.h include this header and add a member to the class Tracking
//
//   maxlogdet::OrbSlam3 mGoodFeatures{200};
//
// and in Tracking::TrackLocalMap replace Optimizer::PoseOptimization(&mCurrentFrame) by
//
//   mGoodFeatures.optimize(mCurrentFrame, Optimizer::PoseOptimization);
//
// and in the same way the two inertial ones, by a lambda, because they have a default argument:
//
//   mGoodFeatures.optimize(mCurrentFrame, [](Frame* f) { return Optimizer::PoseInertialOptimizationLastFrame(f); });
//
// Both also optimise velocity and biases, which matches inform through the pose alone: the six dimensions are the right
// ones. Both pass the information of their matches on as the next frame's prior, which then includes only the selected
// ones: a loss, but no error. With an IMU the optimiser forgives near points up to 1.5 times the threshold; unselected
// matches are judged by the plain one.

namespace maxlogdet {

/// Selection in ORB-SLAM3's tracking thread: pinhole and Kannala-Brandt cameras; monocular, stereo, RGB-D, and rigs of
/// two fisheyes (mpCamera2), whose blocks are about the left one. use_covariances assumes that every keyframe is a
/// rectified pinhole, and leaves out those of rigs.
class OrbSlam3 : public OrbSlamHook {
 public:
  /// As OrbSlam2.
  explicit OrbSlam3(std::size_t budget = 200, std::size_t capacity = 10000) : OrbSlamHook(budget, capacity) {}

  /// As OrbSlam2::optimize.
  template <class Frame, class Optimize>
  int optimize(Frame& frame, const Optimize& pose_optimization) {
    return optimize_selected(
        frame, pose_optimization, [&] { gather(frame); }, [](const Frame& optimized) { return pose_of(optimized); });
  }

 private:
  template <class Frame>
  static RigidTransform pose_of(const Frame& frame) {
    return RigidTransform(frame.GetPose().matrix3x4());
  }

  // As GeometricCamera has it: 0 pinhole, 1 Kannala-Brandt (fx, fy, cx, cy, k1, k2, k3, k4).
  template <class GeometricCamera>
  static Camera camera_of(GeometricCamera& camera, double bf) {
    const auto at = [&](int i) { return static_cast<double>(camera.getParameter(i)); };
    const PinholeCamera pinhole = {at(0), at(1), at(2), at(3), bf};
    constexpr unsigned int fisheye = 1;
    return camera.GetType() == fisheye ? Camera::kannala_brandt(pinhole, at(4), at(5), at(6), at(7)) : Camera(pinhole);
  }

  template <class Frame>
  void gather(Frame& frame) {  // not const, because GetRelativePoseTrl is not
    forget_old_covariances();
    const RigidTransform T_cw = frame.isSet() ? pose_of(frame) : RigidTransform(nullptr);
    is_rig_ = frame.mpCamera2 != nullptr;
    const Camera left = camera_of(*frame.mpCamera, is_rig_ ? 0 : static_cast<double>(frame.mbf));
    const bool is_rectified = left.model == CameraModel::pinhole && left.pinhole.bf > 0;
    if (is_rig_) {
      rig_[0].camera = left;
      rig_[1].camera = camera_of(*frame.mpCamera2, 0);
      rig_[1].T_cb = RigidTransform(frame.GetRelativePoseTrl().matrix3x4());
      features.start(Rig{rig_, 2}, T_cw, DepthCue::none);
    } else {
      features.start(left, T_cw, is_rectified ? DepthCue::stereo : DepthCue::none);
    }
    for_each_match(frame.mvpMapPoints, [&](std::size_t slot) { add_match(frame, *frame.mvpMapPoints[slot], slot); });
  }

  template <class Frame, class MapPoint>
  void add_match(const Frame& frame, MapPoint& point, std::size_t slot) {
    FeatureMatch match;
    set_point(point, match);
    set_numbers(point, match);
    const std::size_t left_count = is_rig_ ? static_cast<std::size_t>(frame.Nleft) : 0;
    const bool is_right = is_rig_ && slot >= left_count;
    const auto& key =
        !is_rig_ ? frame.mvKeysUn[slot] : (is_right ? frame.mvKeysRight[slot - left_count] : frame.mvKeys[slot]);
    match.id = static_cast<std::uint32_t>(slot);
    match.camera_id = is_right ? 1 : 0;
    match.measured[0] = key.pt.x;
    match.measured[1] = key.pt.y;
    if (!is_rig_ && frame.mvuRight[slot] >= 0) match.depth_cue = frame.mvuRight[slot];
    match.sigma = frame.mvScaleFactors[static_cast<std::size_t>(key.octave)];
    features.add(match);
  }

  template <class MapPoint>
  void set_point(MapPoint& point, FeatureMatch& match) {
    const auto p_w = point.GetWorldPos();  // Eigen::Vector3f
    for (int i = 0; i < 3; ++i) match.point[i] = static_cast<double>(p_w(i));
    if (!use_covariances) return;
    match.covariance = covariance_of(point, match.point, [&](PointCovariance& of_point) {
      for (const auto& observation : point.GetObservations()) {  // std::map<KeyFrame*, std::tuple<int, int>>
        auto& keyframe = *observation.first;
        const int i = std::get<0>(observation.second);  // -1: the right camera of a rig alone
        if (i < 0 || keyframe.isBad() || keyframe.mpCamera2 != nullptr) continue;
        const auto slot = static_cast<std::size_t>(i);
        const auto octave = static_cast<std::size_t>(keyframe.mvKeysUn[slot].octave);
        of_point.observe({keyframe.fx, keyframe.fy, keyframe.cx, keyframe.cy, keyframe.mbf},
                         RigidTransform(keyframe.GetPose().matrix3x4()), keyframe.mvScaleFactors[octave],
                         keyframe.mvuRight[slot] >= 0);
      }
    });
  }

  bool is_rig_ = false;
  RigCamera rig_[2];
};

}  // namespace maxlogdet
