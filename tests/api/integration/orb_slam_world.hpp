// SPDX-License-Identifier: MIT
#pragma once

#include "tests/api/integration/adapter_world.hpp"
#include "tests/api/integration/trackers.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

// A frame of ORB-SLAM2 and of ORB-SLAM3, which differ in the types of poses and points, and in their cameras.

namespace maxlogdet::test {

/// What the stand-ins' optimisers were asked for, and what they are to find.
struct OrbCalls {
  std::vector<std::size_t> optimised;  // slots whose map points entered the optimiser
  Eigen::MatrixXd optimum;             // 4 x 4
};
inline OrbCalls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

// Matrices of the trackers' types, in float, from those of Eigen and back.
using RowMajorFloats = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
inline void set(cv::Mat& to, const Eigen::MatrixXd& from) {
  RowMajorFloats rows = from.cast<float>();
  to = cv::Mat(static_cast<int>(rows.rows()), static_cast<int>(rows.cols()), CV_32F, rows.data()).clone();
}
inline void set(Sophus::SE3f& to, const Eigen::MatrixXd& from) {
  const Eigen::MatrixXf T = from.cast<float>();
  to = Sophus::SE3f(Eigen::Matrix3f(T.topLeftCorner<3, 3>()), T.block<3, 1>(0, 3));
}
inline void set(Eigen::Vector3f& to, const Eigen::MatrixXd& from) { to = from.cast<float>(); }

inline Eigen::MatrixXd get(const cv::Mat& from) {
  return Eigen::Map<const RowMajorFloats>(from.ptr<float>(), from.rows, from.cols).cast<double>();
}
inline Eigen::MatrixXd get(const Sophus::SE3f& from) { return from.matrix3x4().cast<double>(); }
inline Eigen::MatrixXd get(const Eigen::Vector3f& from) { return from.cast<double>(); }
template <class Pose>
sim::Pose pose_of(const Pose& from) {
  sim::Pose T = sim::Pose::Identity();
  T.matrix().topRows<3>() = get(from).topRows(3);
  return T;
}

/// Takes every match that is not null for an inlier, whatever its flag, and finds the pose that it is told to find.
template <class Frame>
int find_optimum(Frame* frame) {
  calls.optimised.clear();
  for (std::size_t i = 0; i < frame->mvpMapPoints.size(); ++i) {
    if (frame->mvpMapPoints[i] == nullptr) continue;
    frame->mvbOutlier[i] = false;
    calls.optimised.push_back(i);
  }
  auto T_cw = frame->mTcw;
  set(T_cw, calls.optimum);
  frame->SetPose(T_cw);
  return static_cast<int>(calls.optimised.size());
}

enum class Sensor { monocular, stereo, fisheye, rig };

/// The cameras of a frame. ORB-SLAM2 knows a pinhole alone.
struct OrbCameras {
  void set_in(ORB_SLAM2::Frame& /*frame*/, Sensor /*sensor*/) {}
  void set_in(ORB_SLAM3::Frame& frame, Sensor sensor) {
    frame.mpCamera = sensor == Sensor::fisheye || sensor == Sensor::rig ? &fisheye : &pinhole;
    if (sensor != Sensor::rig) return;
    frame.mpCamera2 = &right_fisheye;
    set(frame.mTrl, T_rl.matrix());
  }

  ORB_SLAM3::GeometricCamera pinhole = {{458, 457, 367, 248}, 0};
  ORB_SLAM3::GeometricCamera fisheye = {{190, 191, 255, 256, -0.01F, -0.002F, 0.001F, -0.0003F}, 1};
  ORB_SLAM3::GeometricCamera right_fisheye = {{190, 191, 255, 256, 0.02F, -0.002F, 0.001F, -0.0003F}, 1};
  sim::Pose T_rl = sim::exp_se3((sim::Vector6() << -0.1, 0.02, 0.01, 0.1, -0.2, 0.05).finished());
};

/// Of a fisheye, the distance from the centre is an odd polynomial of the angle to the axis.
inline Eigen::Vector2d project(const ORB_SLAM3::GeometricCamera& camera, const Eigen::Vector3d& p) {
  const auto parameter = [&](std::size_t i) { return double{camera.mvParameters[i]}; };
  const double radius = std::hypot(p.x(), p.y()), theta = std::atan2(radius, p.z());
  double distance = theta;
  for (std::size_t i = 4; i < camera.mvParameters.size(); ++i) {
    distance += parameter(i) * std::pow(theta, 2 * static_cast<double>(i) - 5);
  }
  const double scale = camera.mnType == 1 ? distance / radius : 1 / p.z();
  return {parameter(0) * scale * p.x() + parameter(2), parameter(1) * scale * p.y() + parameter(3)};
}

/// Where keypoints of the left camera are, and those of the right one.
inline std::vector<cv::KeyPoint>& keys_of(ORB_SLAM2::Frame& frame, bool /*is_rig*/, bool /*is_right*/) {
  return frame.mvKeysUn;
}
inline std::vector<cv::KeyPoint>& keys_of(ORB_SLAM3::Frame& frame, bool is_rig, bool is_right) {
  if (is_rig && !is_right) frame.Nleft = static_cast<int>(frame.mvKeys.size()) + 1;  // once the key is there
  return !is_rig ? frame.mvKeysUn : is_right ? frame.mvKeysRight : frame.mvKeys;
}

inline void forget_pose(ORB_SLAM2::Frame& frame) { frame.mTcw = cv::Mat(); }
inline void forget_pose(ORB_SLAM3::Frame& frame) { frame.mbIsSet = false; }

// Where a keyframe sees a point.
inline void set_place(std::size_t& place, std::size_t slot) { place = slot; }
inline void set_place(std::tuple<int, int>& place, std::size_t slot) { place = {static_cast<int>(slot), -1}; }
inline std::size_t slot_of(std::size_t place) { return place; }
inline std::size_t slot_of(const std::tuple<int, int>& place) { return static_cast<std::size_t>(std::get<0>(place)); }

/// Matches without noise at the true pose; every fifth one is off by 20 deviations. The frame's pose is a guess, at
/// which all would be outliers. Every sixth slot is empty; flags are left over from before. In stereo every second
/// match has a right column; of a rig three matches of five are those of its right camera. Two keyframes, one of them
/// stereo, observe every point.
template <class Tracking>
class OrbWorld : public AdapterWorld {
 public:
  using Adapter = decltype(Tracking::mGoodFeatures);
  using Frame = decltype(Tracking::mCurrentFrame);
  using MapPoint = std::remove_pointer_t<typename decltype(Frame::mvpMapPoints)::value_type>;
  using KeyFrame = std::remove_pointer_t<typename decltype(MapPoint::mObservations)::key_type>;

  OrbWorld(Random& random, std::size_t n, std::size_t budget, std::size_t capacity, Sensor of = Sensor::monocular)
      : sensor(of), T_cw(random_pose(random)), n_(n) {
    calls = OrbCalls();
    calls.optimum = T_cw.matrix();
    good = Adapter(budget, capacity);
    good.features.rejects_outliers = false;  // selection among all, at the frame's pose
    frame.mvScaleFactors = {1, 1.2F, 1.44F};
    frame.mbf = sensor == Sensor::stereo ? 50 : 0;
    cameras.set_in(frame, sensor);
    for (KeyFrame& keyframe : keyframes) {
      set(keyframe.mTcw, near(random, 0.4, 0.05).matrix());
      keyframe.mbf = 50;
      keyframe.mvScaleFactors = frame.mvScaleFactors;
    }
    while (slots.size() < n) add_slot(random);
    auto guess = frame.mTcw;
    set(guess, (sim::exp_se3((sim::Vector6() << 0.3, 0.2, 0.3, 0.1, 0.1, 0.1).finished()) * T_cw).matrix());
    frame.SetPose(guess);
  }

  TrackerHook& hook() override { return good; }

  // What enters the optimiser. Every match is in the frame afterwards.
  std::set<std::size_t> run() override {
    const std::vector<MapPoint*> before = frame.mvpMapPoints;
    tracking.TrackLocalMap();
    EXPECT_EQ(frame.mvpMapPoints, before);
    std::set<std::size_t> matches;
    for (const std::size_t slot : calls.optimised) {
      matches.insert(static_cast<std::size_t>(std::find(slots.begin(), slots.end(), slot) - slots.begin()));
    }
    return matches;
  }

  std::vector<SeenPoint> seen() const override {
    std::vector<SeenPoint> all;
    for (std::size_t i = 0; i < n_; ++i) {
      const auto measured = [this, i](const Eigen::Vector3d& p) { return measure(i, p); };
      all.push_back({measured, pose_of(frame.mTcw) * position_of(i), sigma_of(i)});
    }
    return all;
  }
  // With the covariances that the keyframes leave.
  std::vector<SeenPoint> seen_with_covariances() const {
    std::vector<SeenPoint> all = seen();
    const Eigen::Matrix3d R_cw = pose_of(frame.mTcw).linear();
    for (std::size_t i = 0; i < n_; ++i) all[i].covariance = R_cw * covariance_of(point(i)) * R_cw.transpose();
    return all;
  }

  void lose_pose() override { forget_pose(frame); }
  // Its point, or where it is seen.
  void make_not_finite(std::size_t i) override {
    if (i % 2 == 0 && sensor != Sensor::rig) {
      frame.mvKeysUn[slots[i]].pt.y = static_cast<float>(nan);
    } else {
      set(point(i).mWorldPos, Eigen::Vector3d(0, nan, 0));
    }
  }
  void put_behind_camera(std::size_t i) override {
    set(point(i).mWorldPos, T_cw.inverse() * Eigen::Vector3d(0, 0, -5));
  }
  bool is_outlier(std::size_t i) const override { return frame.mvbOutlier[slots[i]]; }
  bool has_outliers() const override { return true; }

  std::map<std::string, double> recorded(std::size_t i) const override {
    std::map<std::string, double> row = {{"kp", slots[i]},
                                         {"mp_id", point(i).mnId},
                                         {"keyframe", point(i).mnFirstKFid},
                                         {"X", position_of(i).x()},
                                         {"Z", position_of(i).z()},
                                         {"u", keys[i].pt.x},
                                         {"v", keys[i].pt.y},
                                         {"inv_sigma2", std::pow(sigma_of(i), -2)}};
    if (sensor == Sensor::rig) row["camera"] = is_right(i) ? 1 : 0;
    if (sensor == Sensor::stereo) row["u_right"] = is_stereo(i) ? frame.mvuRight[slots[i]] : -1;
    return row;
  }

  bool is_stereo(std::size_t i) const { return frame.mvuRight[slots[i]] >= 0; }
  bool is_right(std::size_t i) const { return sensor == Sensor::rig && 5 * i >= 2 * n_; }
  bool is_wrong(std::size_t i) const { return i % 5 == 0; }
  double sigma_of(std::size_t i) const { return double{frame.mvScaleFactors[i % 3]}; }
  MapPoint& point(std::size_t i) const { return *frame.mvpMapPoints[slots[i]]; }
  Eigen::Vector3d position_of(std::size_t i) const { return get(point(i).mWorldPos); }

  // Where a match's camera sees a point in the frame of the left camera.
  Eigen::Vector2d project_by_camera_of(std::size_t i, const Eigen::Vector3d& p) const {
    if (is_right(i)) return project(cameras.right_fisheye, cameras.T_rl * p);
    return project(sensor == Sensor::fisheye || sensor == Sensor::rig ? cameras.fisheye : cameras.pinhole, p);
  }
  // u, v and, in stereo, u_right.
  Eigen::VectorXd measure(std::size_t i, const Eigen::Vector3d& p) const {
    const Eigen::Vector2d uv = project_by_camera_of(i, p);
    if (!is_stereo(i)) return uv;
    return Eigen::Vector3d(uv.x(), uv.y(), uv.x() - frame.mbf / p.z());
  }

  // Up to so far from the true pose.
  sim::Pose near(Random& random, double metres, double radians) const {
    return sim::exp_se3((sim::Vector6() << random_vector(random, metres), random_vector(random, radians)).finished()) *
           T_cw;
  }

  // The keyframe observes the point once more, in another octave.
  void observe(Random& random, MapPoint& of, KeyFrame& keyframe, bool stereo) {
    set_place(of.mObservations[&keyframe], keyframe.mvKeysUn.size());
    of.nObs += stereo ? 2 : 1;
    keyframe.mvKeysUn.emplace_back();
    keyframe.mvKeysUn.back().octave = random.integer(0, 2);
    keyframe.mvuRight.push_back(stereo ? 100.0F : -1.0F);
  }

  Sensor sensor;
  Tracking tracking;
  Adapter& good = tracking.mGoodFeatures;
  Frame& frame = tracking.mCurrentFrame;
  sim::Pose T_cw;
  std::vector<std::size_t> slots;  // of the matches
  std::vector<cv::KeyPoint> keys;  // of the matches
  std::vector<std::unique_ptr<MapPoint>> points;
  KeyFrame keyframes[2];
  OrbCameras cameras;

 private:
  void add_slot(Random& random) {
    const bool is_empty = frame.mvpMapPoints.size() % 6 == 3;
    const std::size_t i = slots.size();
    const Eigen::Vector3d p_c = random_point_in_camera(random);
    const Eigen::Vector2d uv = project_by_camera_of(i, p_c);
    cv::KeyPoint key;
    key.octave = static_cast<int>(i % 3);
    key.pt.x = static_cast<float>(uv.x() + (is_wrong(i) ? 20 * sigma_of(i) : 0));
    key.pt.y = static_cast<float>(uv.y());
    keys_of(frame, sensor == Sensor::rig, is_right(i)).push_back(key);
    const bool has_right_column = sensor == Sensor::stereo && i % 2 == 0 && !is_empty;
    frame.mvuRight.push_back(has_right_column ? static_cast<float>(uv.x() - frame.mbf / p_c.z()) : -1);
    frame.mvbOutlier.push_back(random.chance(0.5));
    frame.mvpMapPoints.push_back(nullptr);
    if (is_empty) return;
    keys.push_back(key);
    slots.push_back(frame.mvpMapPoints.size() - 1);
    points.push_back(std::make_unique<MapPoint>());
    MapPoint& made = *points.back();
    made.mnId = points.size();
    made.mnFirstKFid = static_cast<long int>(points.size() / 50) - 1;
    set(made.mWorldPos, T_cw.inverse() * p_c);
    for (KeyFrame& keyframe : keyframes) observe(random, made, keyframe, &keyframe == keyframes);
    frame.mvpMapPoints.back() = &made;
  }

  // From derivatives by differences, summed over the keyframes that are not bad.
  static Eigen::Matrix3d covariance_of(MapPoint& point) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (const auto& [keyframe, place] : point.GetObservations()) {
      const std::size_t slot = slot_of(place);
      if (keyframe->isBad() || slot >= keyframe->mvKeysUn.size()) continue;
      const double fx = double{keyframe->fx}, fy = double{keyframe->fy};
      const double bf = keyframe->mvuRight[slot] >= 0 ? double{keyframe->mbf} : 0;
      const sim::Pose T_kw = pose_of(keyframe->mTcw);
      const SeenPoint as_seen = {[=](const Eigen::Vector3d& p) { return seen_by_pinhole(p, fx, fy, bf); },
                                 T_kw * Eigen::Vector3d(get(point.mWorldPos))};
      information += std::pow(1.2, -2 * keyframe->mvKeysUn[slot].octave) * gram(as_seen.H_p() * T_kw.linear());
    }
    return inverse(information + 1e-8 * information.trace() * Eigen::Matrix3d::Identity());
  }

  std::size_t n_;
};

}  // namespace maxlogdet::test

namespace ORB_SLAM2 {

float Frame::fx = 458;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::fy = 457;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cx = 367;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cy = 248;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

int Optimizer::PoseOptimization(Frame* pFrame) { return maxlogdet::test::find_optimum(pFrame); }

}  // namespace ORB_SLAM2

namespace ORB_SLAM3 {

int Optimizer::PoseOptimization(Frame* pFrame) { return maxlogdet::test::find_optimum(pFrame); }
int Optimizer::PoseInertialOptimizationLastKeyFrame(Frame* pFrame, bool /*bRecInit*/) {
  return PoseOptimization(pFrame);
}

}  // namespace ORB_SLAM3
