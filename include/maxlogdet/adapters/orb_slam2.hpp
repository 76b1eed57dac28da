// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/orb_slam.hpp>
#include <maxlogdet/opencv.hpp>

// docs/trackers.md says where its lines go. Frame::mTcw has to be a cv::Mat, as in the published version.

namespace maxlogdet {

/// Selection in ORB-SLAM2's tracking thread, monocular, stereo and RGB-D (whose depth is a virtual right column there).
class OrbSlam2 : public OrbSlamHook<OrbSlam2> {
 public:
  using OrbSlamHook<OrbSlam2>::OrbSlamHook;

 private:
  friend class OrbSlamHook<OrbSlam2>;

  template <class Frame>
  static RigidTransform pose_of(const Frame& frame) {
    return frame.mTcw;  // empty before the first pose: refused
  }

  template <class Frame>
  static void set_pose(const RigidTransform& T_cw, Frame& frame) {
    cv::Mat pose(4, 4, CV_32F);
    for (int i = 0; i < 16; ++i) pose.at<float>(i / 4, i % 4) = static_cast<float>(i < 12 ? T_cw.data()[i] : i / 15);
    frame.SetPose(pose);
  }

  template <class Frame>
  void start(const Frame& frame) {
    features.start(Camera(frame.fx, frame.fy, frame.cx, frame.cy, frame.mbf), pose_of(frame));
  }

  template <class Frame>
  void add(const Frame& frame, std::size_t slot) {
    add_match(frame, slot, frame.mvKeysUn[slot], frame.mvuRight[slot]);
  }
};

}  // namespace maxlogdet
