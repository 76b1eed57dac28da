// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/orb_slam.hpp>
#include <maxlogdet/eigen.hpp>

#include <type_traits>

// docs/trackers.md says where its lines go.
//
// With an IMU the optimiser also estimates velocity and biases, which matches inform through the pose alone: the six
// dimensions are the right ones. It passes the information of its matches on as the next frame's prior, which then
// includes only the selected ones: a loss, but no error. It forgives near points up to 1.5 times the threshold;
// unselected matches are judged by the plain one.

namespace maxlogdet {

/// Selection in ORB-SLAM3's tracking thread: pinhole and Kannala-Brandt cameras; monocular, stereo, RGB-D, and rigs of
/// two fisheyes (mpCamera2), whose blocks are about the left one. From 1.0 on, where GetPose() is a Sophus::SE3f.
class OrbSlam3 : public OrbSlamHook<OrbSlam3> {
 public:
  using OrbSlamHook<OrbSlam3>::OrbSlamHook;

 private:
  friend class OrbSlamHook<OrbSlam3>;

  template <class Frame>
  static RigidTransform pose_of(const Frame& frame) {
    return frame.isSet() ? RigidTransform(frame.GetPose()) : RigidTransform(nullptr);
  }

  template <class Frame>
  static void set_pose(const RigidTransform& T_cw, Frame& frame) {
    frame.SetPose(PoseTraits<typename std::decay<decltype(frame.GetPose())>::type>::make(T_cw));
  }

  // As GeometricCamera has it: 0 pinhole, 1 Kannala-Brandt (fx, fy, cx, cy, k1, k2, k3, k4).
  template <class GeometricCamera>
  static Camera camera_of(GeometricCamera& camera, double bf) {
    const auto at = [&](int i) { return static_cast<double>(camera.getParameter(i)); };
    const PinholeCamera pinhole = {at(0), at(1), at(2), at(3), bf};
    return camera.GetType() == 1 ? Camera::kannala_brandt(pinhole, at(4), at(5), at(6), at(7)) : Camera(pinhole);
  }

  template <class Frame>
  void start(Frame& frame) {  // not const, because GetRelativePoseTrl is not
    const bool is_rig = frame.mpCamera2 != nullptr;
    const Camera left = camera_of(*frame.mpCamera, is_rig ? 0 : static_cast<double>(frame.mbf));
    has_right_column_ = left.model == CameraModel::pinhole && left.pinhole.bf > 0;
    if (!is_rig) return features.start(left, pose_of(frame));
    rig_[0] = left;
    rig_[1] = camera_of(*frame.mpCamera2, 0);
    rig_[1].T_cb = frame.GetRelativePoseTrl();
    features.start(rig_, 2, pose_of(frame));
  }

  template <class Frame>
  void add(const Frame& frame, std::size_t slot) {
    if (frame.mpCamera2 == nullptr) {
      return add_match(frame, slot, frame.mvKeysUn[slot], has_right_column_ ? frame.mvuRight[slot] : -1);
    }
    const auto left_count = static_cast<std::size_t>(frame.Nleft);
    const bool is_right = slot >= left_count;
    add_match(frame, slot, is_right ? frame.mvKeysRight[slot - left_count] : frame.mvKeys[slot], -1, is_right ? 1 : 0);
  }

  bool has_right_column_ = false;
  Camera rig_[2];
};

}  // namespace maxlogdet
