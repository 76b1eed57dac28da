// SPDX-License-Identifier: MIT
#include "tests/api/integration/orb_slam_world.hpp"

namespace maxlogdet::test {

OrbCalls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

namespace {

// Takes every match that is not null for an inlier, whatever its flag, and finds the pose that it is told to find.
template <class Slam, class Frame>
int find_optimum(Frame* frame) {
  calls.optimised.clear();
  for (std::size_t i = 0; i < frame->mvpMapPoints.size(); ++i) {
    if (frame->mvpMapPoints[i] == nullptr) continue;
    frame->mvbOutlier[i] = false;
    calls.optimised.push_back(i);
  }
  Slam::set_pose(*frame, calls.optimum);
  return static_cast<int>(calls.optimised.size());
}

}  // namespace
}  // namespace maxlogdet::test

namespace ORB_SLAM2 {

float Frame::fx = 458;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::fy = 457;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cx = 367;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cy = 248;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

int Optimizer::PoseOptimization(Frame* pFrame) { return maxlogdet::test::find_optimum<maxlogdet::test::Slam2>(pFrame); }

// Asks what each stereo match weighs, and optimises nothing.
int weighted::Optimizer::PoseOptimization(Frame* pFrame, const maxlogdet::OrbSlam2* good) {
  maxlogdet::test::calls.weights.clear();
  for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
    if (pFrame->mvpMapPoints[i] == nullptr || pFrame->mvuRight[i] < 0) continue;
    maxlogdet::test::calls.weights[i] = information_of_edge(pFrame, i, good);
  }
  return 0;
}

}  // namespace ORB_SLAM2

namespace ORB_SLAM3 {

int Optimizer::PoseOptimization(Frame* pFrame) { return maxlogdet::test::find_optimum<maxlogdet::test::Slam3>(pFrame); }

int Optimizer::PoseInertialOptimizationLastKeyFrame(Frame* pFrame, bool /*bRecInit*/) {
  return PoseOptimization(pFrame);
}

}  // namespace ORB_SLAM3

namespace maxlogdet::test {

cv::Mat to_mat(const sim::Pose& T) {
  cv::Mat mat(4, 4, CV_32F);
  for (int i = 0; i < 16; ++i) mat.at<float>(i / 4, i % 4) = static_cast<float>(T.matrix()(i / 4, i % 4));
  return mat;
}

sim::Pose to_pose(const cv::Mat& mat) {
  sim::Pose T = sim::Pose::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = double{mat.at<float>(i / 4, i % 4)};
  return T;
}

Sophus::SE3f in_float(const sim::Pose& T) { return {T.linear().cast<float>(), T.translation().cast<float>()}; }

OrbCameras::OrbCameras() {
  sim::Vector6 xi;
  xi << -0.1, 0.02, 0.01, 0.1, -0.2, 0.05;
  T_rl = sim::exp_se3(xi);
}

void Slam2::set_position(MapPoint& point, const Eigen::Vector3d& p_w) {
  point.mWorldPos = cv::Mat(3, 1, CV_32F);
  for (int d = 0; d < 3; ++d) point.mWorldPos.at<float>(d) = static_cast<float>(p_w(d));
}

Eigen::Vector3d Slam2::position_of(MapPoint& point) {
  const cv::Mat p = point.GetWorldPos();
  return {double{p.at<float>(0)}, double{p.at<float>(1)}, double{p.at<float>(2)}};
}

cv::KeyPoint& Slam2::add_key(Frame& frame, bool /*is_rig*/, bool /*is_right*/) {
  frame.mvKeysUn.emplace_back();
  return frame.mvKeysUn.back();
}

void Slam3::set_cameras(Frame& frame, Sensor sensor, OrbCameras& cameras) {
  const bool is_fisheye = sensor == Sensor::fisheye || sensor == Sensor::rig;
  frame.mpCamera = is_fisheye ? static_cast<ORB_SLAM3::GeometricCamera*>(&cameras.fisheye) : &cameras.pinhole;
  if (sensor != Sensor::rig) return;
  frame.mpCamera2 = &cameras.right_fisheye;
  frame.mTrl = in_float(cameras.T_rl);
}

cv::KeyPoint& Slam3::add_key(Frame& frame, bool is_rig, bool is_right) {
  std::vector<cv::KeyPoint>& keys = !is_rig ? frame.mvKeysUn : is_right ? frame.mvKeysRight : frame.mvKeys;
  keys.emplace_back();
  return keys.back();
}

}  // namespace maxlogdet::test
