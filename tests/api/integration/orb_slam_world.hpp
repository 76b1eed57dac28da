// SPDX-License-Identifier: MIT
#pragma once

#include "tests/api/integration/adapter_world.hpp"
#include "tests/api/integration/orb_slam2_snippets.hpp"
#include "tests/api/integration/orb_slam3_snippets.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

// A frame of ORB-SLAM2 and of ORB-SLAM3, which differ in the types of poses and points.

namespace maxlogdet::test {

/// What the stand-ins' optimisers were asked for, and what they are to find.
struct OrbCalls {
  std::vector<std::size_t> optimised;              // slots whose map points entered the optimiser
  std::map<std::size_t, Eigen::Matrix3d> weights;  // by slot, of the edges of stereo matches
  sim::Pose optimum;
};
extern OrbCalls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

cv::Mat to_mat(const sim::Pose& T);
sim::Pose to_pose(const cv::Mat& mat);
inline sim::Pose to_pose(const Sophus::SE3f& T) {
  return transform(T.rotationMatrix().cast<double>(), T.translation().cast<double>());
}
Sophus::SE3f in_float(const sim::Pose& T);

class Pinhole : public ORB_SLAM3::GeometricCamera {
 public:
  Pinhole() : GeometricCamera({458, 457, 367, 248}, CAM_PINHOLE) {}
  Eigen::Vector2d project(const Eigen::Vector3d& p) override {
    return {458 * p.x() / p.z() + 367, 457 * p.y() / p.z() + 248};
  }
};

/// The distance from the centre is an odd polynomial of the angle to the axis.
class KannalaBrandt8 : public ORB_SLAM3::GeometricCamera {
 public:
  explicit KannalaBrandt8(float k1)
      : GeometricCamera({190, 191, 255, 256, k1, -0.002F, 0.001F, -0.0003F}, CAM_FISHEYE) {}
  Eigen::Vector2d project(const Eigen::Vector3d& p) override {
    const double radius = std::hypot(p.x(), p.y());
    const double theta = std::atan2(radius, p.z());
    double d = theta;
    for (std::size_t i = 0; i < 4; ++i) d += mvParameters[4 + i] * std::pow(theta, 3 + 2 * static_cast<double>(i));
    return {190 * d * p.x() / radius + 255, 191 * d * p.y() / radius + 256};
  }
};

enum class Sensor { monocular, stereo, fisheye, rig };

/// The cameras of a frame.
struct OrbCameras {
  OrbCameras();

  Pinhole pinhole;
  KannalaBrandt8 fisheye{-0.01F}, right_fisheye{0.02F};
  sim::Pose T_rl;
};

/// The types of ORB-SLAM2.
struct Slam2 {
  using Frame = ORB_SLAM2::Frame;
  using KeyFrame = ORB_SLAM2::KeyFrame;
  using MapPoint = ORB_SLAM2::MapPoint;
  using Adapter = OrbSlam2;
  static constexpr auto optimize = ORB_SLAM2::Optimizer::PoseOptimization;

  static void set_pose(KeyFrame& keyframe, const sim::Pose& T_cw) { keyframe.Tcw = to_mat(T_cw); }
  static sim::Pose pose_of(const Frame& frame) { return to_pose(frame.mTcw); }
  static sim::Pose pose_of(KeyFrame& keyframe) { return to_pose(keyframe.Tcw); }
  static void set_position(MapPoint& point, const Eigen::Vector3d& p_w);
  static Eigen::Vector3d position_of(MapPoint& point);
  static std::size_t seen_at(int slot) { return static_cast<std::size_t>(slot); }
  static void set_pose(Frame& frame, const sim::Pose& T_cw) { frame.SetPose(to_mat(T_cw)); }
  static void forget_pose(Frame& frame) { frame.mTcw = cv::Mat(); }
  // It knows a pinhole alone.
  static void set_cameras(Frame& /*frame*/, Sensor /*sensor*/, OrbCameras& /*cameras*/) {}
  static cv::KeyPoint& add_key(Frame& frame, bool /*is_rig*/, bool /*is_right*/);
};

/// The types of ORB-SLAM3.
struct Slam3 {
  using Frame = ORB_SLAM3::Frame;
  using KeyFrame = ORB_SLAM3::KeyFrame;
  using MapPoint = ORB_SLAM3::MapPoint;
  using Adapter = OrbSlam3;
  static constexpr auto optimize = ORB_SLAM3::Optimizer::PoseOptimization;

  static void set_pose(KeyFrame& keyframe, const sim::Pose& T_cw) { keyframe.mTcw = in_float(T_cw); }
  static sim::Pose pose_of(const Frame& frame) { return to_pose(frame.GetPose()); }
  static sim::Pose pose_of(KeyFrame& keyframe) { return to_pose(keyframe.GetPose()); }
  static void set_position(MapPoint& point, const Eigen::Vector3d& p_w) { point.mWorldPos = p_w.cast<float>(); }
  static Eigen::Vector3d position_of(MapPoint& point) { return point.mWorldPos.cast<double>(); }
  static std::tuple<int, int> seen_at(int slot) { return {slot, -1}; }
  static void set_pose(Frame& frame, const sim::Pose& T_cw) { frame.SetPose(in_float(T_cw)); }
  static void forget_pose(Frame& frame) { frame.mbIsSet = false; }
  static void set_cameras(Frame& frame, Sensor sensor, OrbCameras& cameras);
  static cv::KeyPoint& add_key(Frame& frame, bool is_rig, bool is_right);
};

/// Matches without noise at the true pose; every fifth one is off by 20 deviations. The frame's pose is a guess, at
/// which all would be outliers. Every sixth slot is empty; flags are left over from before. In stereo every second
/// match has a right column; of a rig three matches of five are those of its right camera. Two keyframes, one of them
/// stereo, observe every point.
template <class Slam>
class OrbWorld : public AdapterWorld {
 public:
  using Frame = typename Slam::Frame;
  using KeyFrame = typename Slam::KeyFrame;
  using MapPoint = typename Slam::MapPoint;

  OrbWorld(Random& random, std::size_t n, std::size_t budget, std::size_t capacity, Sensor of = Sensor::monocular)
      : sensor(of), good(budget, capacity), T_cw(random_pose(random)), n_(n) {
    calls = OrbCalls();
    calls.optimum = T_cw;
    good.features.rejects_outliers = false;  // selection among all, at the frame's pose
    frame.mvScaleFactors = {1, 1.2F, 1.44F};
    frame.mbf = sensor == Sensor::stereo ? 50 : 0;
    Slam::set_cameras(frame, sensor, *cameras);
    for (KeyFrame& keyframe : keyframes) {
      Slam::set_pose(keyframe, near(random, 0.4, 0.05));
      keyframe.mbf = 50;
      keyframe.mvScaleFactors = frame.mvScaleFactors;
    }
    while (slots.size() < n) add_slot(random);
    frame.N = static_cast<int>(frame.mvpMapPoints.size());
    if (sensor == Sensor::rig) set_left_count();
    sim::Vector6 xi;
    xi << 0.3, 0.2, 0.3, 0.1, 0.1, 0.1;
    Slam::set_pose(frame, sim::exp_se3(xi) * T_cw);
  }

  TrackerHook& hook() override { return good; }

  // What enters the optimiser. Every match is in the frame afterwards, and those without a flag are the inliers.
  std::set<std::size_t> run() override {
    const std::vector<MapPoint*> before = frame.mvpMapPoints;
    const int inliers = good.optimize(frame, Slam::optimize);
    EXPECT_EQ(frame.mvpMapPoints, before);
    int expected = 0;
    for (const std::size_t slot : slots) expected += frame.mvbOutlier[slot] ? 0 : 1;
    EXPECT_EQ(inliers, expected);
    std::set<std::size_t> matches;
    for (const std::size_t slot : calls.optimised) {
      matches.insert(static_cast<std::size_t>(std::find(slots.begin(), slots.end(), slot) - slots.begin()));
    }
    return matches;
  }

  std::vector<Matrix6> informations() const override {
    std::vector<Matrix6> all;
    for (std::size_t i = 0; i < n_; ++i) {
      const auto measured = [&](const Eigen::Vector3d& p) { return measure(i, p); };
      const Eigen::MatrixXd H_x = derivative_under_left_perturbation(measured, in_camera(i));
      all.emplace_back(gram(H_x) / std::pow(sigma_of(i), 2));
    }
    return all;
  }

  void lose_pose() override { Slam::forget_pose(frame); }
  // Its point, or where it is seen.
  void make_not_finite(std::size_t i) override {
    if (i % 2 == 0 && sensor != Sensor::rig) {
      frame.mvKeysUn[slots[i]].pt.y = std::numeric_limits<float>::quiet_NaN();
    } else {
      Slam::set_position(point(i), {0, nan, 0});
    }
  }
  void put_behind_camera(std::size_t i) override {
    Slam::set_position(point(i), T_cw.inverse() * Eigen::Vector3d(0, 0, -5));
  }
  bool is_outlier(std::size_t i) const override { return frame.mvbOutlier[slots[i]]; }
  bool has_outliers() const override { return true; }

  std::map<std::string, double> recorded(std::size_t i) const override {
    const Eigen::Vector3d p_w = Slam::position_of(point(i));
    std::map<std::string, double> row = {{"kp", slots[i]},
                                         {"mp_id", point(i).mnId},
                                         {"keyframe", point(i).mnFirstKFid},
                                         {"X", p_w.x()},
                                         {"Z", p_w.z()},
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
  Eigen::Vector3d in_camera(std::size_t i) const { return Slam::pose_of(frame) * Slam::position_of(point(i)); }

  // Where a match's camera sees a point in the frame of the left camera.
  Eigen::Vector2d project(std::size_t i, const Eigen::Vector3d& p) const {
    if (is_right(i)) return cameras->right_fisheye.project(cameras->T_rl * p);
    const bool is_fisheye = sensor == Sensor::fisheye || sensor == Sensor::rig;
    return is_fisheye ? cameras->fisheye.project(p) : cameras->pinhole.project(p);
  }
  // u, v and, in stereo, u_right.
  Eigen::VectorXd measure(std::size_t i, const Eigen::Vector3d& p) const {
    const Eigen::Vector2d uv = project(i, p);
    if (!is_stereo(i)) return uv;
    return Eigen::Vector3d(uv.x(), uv.y(), uv.x() - frame.mbf / p.z());
  }

  // Up to so far from the true pose.
  sim::Pose near(Random& random, double metres, double radians) const {
    sim::Vector6 xi;
    xi << random_vector(random, metres), random_vector(random, radians);
    return sim::exp_se3(xi) * T_cw;
  }

  // The point as seen with the covariance that its keyframes leave; with none, without.
  SeenPoint seen(std::size_t i, bool with_covariance) {
    SeenPoint as_seen{in_camera(i), is_stereo(i) ? double{frame.mbf} : 0, 458, 457, sigma_of(i)};
    const Eigen::Matrix3d R_cw = Slam::pose_of(frame).linear();
    if (with_covariance) as_seen.covariance = R_cw * covariance_of(point(i)) * R_cw.transpose();
    return as_seen;
  }
  std::vector<SeenPoint> all_seen() {
    std::vector<SeenPoint> all;
    for (std::size_t i = 0; i < n_; ++i) all.push_back(seen(i, true));
    return all;
  }

  // The keyframe observes the point once more, in another octave.
  void observe(Random& random, MapPoint& of, KeyFrame& keyframe, bool stereo) {
    of.mObservations[&keyframe] = Slam::seen_at(static_cast<int>(keyframe.mvKeysUn.size()));
    of.nObs += stereo ? 2 : 1;
    keyframe.mvKeysUn.emplace_back();
    keyframe.mvKeysUn.back().octave = random.integer(0, 2);
    keyframe.mvuRight.push_back(stereo ? 100.0F : -1.0F);
  }

  Sensor sensor;
  typename Slam::Adapter good;
  sim::Pose T_cw;
  Frame frame;
  std::vector<std::size_t> slots;  // of the matches
  std::vector<cv::KeyPoint> keys;  // of the matches
  std::vector<std::unique_ptr<MapPoint>> points;
  KeyFrame keyframes[2];
  std::unique_ptr<OrbCameras> cameras = std::make_unique<OrbCameras>();

 private:
  void add_slot(Random& random) {
    const bool is_empty = frame.mvpMapPoints.size() % 6 == 3;
    const std::size_t i = slots.size();
    const Eigen::Vector3d p_c = random_point_in_camera(random);
    const Eigen::Vector2d uv = project(i, p_c);
    cv::KeyPoint& key = Slam::add_key(frame, sensor == Sensor::rig, is_right(i));
    key.octave = static_cast<int>(i % 3);
    key.pt.x = static_cast<float>(uv.x() + (is_wrong(i) ? 20 * sigma_of(i) : 0));
    key.pt.y = static_cast<float>(uv.y());
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
    Slam::set_position(made, T_cw.inverse() * p_c);
    for (KeyFrame& keyframe : keyframes) observe(random, made, keyframe, &keyframe == keyframes);
    frame.mvpMapPoints.back() = &made;
  }

  void set_left_count() {
    if constexpr (std::is_same<Slam, Slam3>::value) frame.Nleft = static_cast<int>(frame.mvKeys.size());
  }

  // From derivatives by differences, summed over the keyframes that are not bad.
  static Eigen::Matrix3d covariance_of(MapPoint& point) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (const auto& observation : point.GetObservations()) {
      KeyFrame& keyframe = *observation.first;
      const auto slot = slot_of(observation.second);
      if (keyframe.isBad() || slot >= keyframe.mvKeysUn.size()) continue;
      const sim::Pose T_kw = Slam::pose_of(keyframe);
      const bool stereo = keyframe.mvuRight[slot] >= 0;
      const Derivatives derivatives(
          {T_kw * Slam::position_of(point), stereo ? keyframe.mbf : 0.0, keyframe.fx, keyframe.fy});
      const Eigen::MatrixXd H_p = derivatives.H_p.topRows(stereo ? 3 : 2) * T_kw.linear();
      information += std::pow(1.2, -2 * keyframe.mvKeysUn[slot].octave) * gram(H_p);
    }
    return inverse(information + 1e-8 * information.trace() * Eigen::Matrix3d::Identity());
  }
  static std::size_t slot_of(std::size_t observation) { return observation; }
  static std::size_t slot_of(const std::tuple<int, int>& observation) {
    return static_cast<std::size_t>(std::get<0>(observation));
  }

  std::size_t n_;
};

}  // namespace maxlogdet::test
