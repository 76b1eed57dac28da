// SPDX-License-Identifier: MIT
// The adapter of ORB-SLAM3 and the guide's lines for it, with pinholes, fisheyes and rigs of two: blocks, flags,
// covariances, recorded frames.
#include "tests/api/integration/orb_slam3_snippets.hpp"

#include "tests/api/integration/oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/recording.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

namespace {

// What the stand-ins were asked for.
struct Calls {
  std::vector<std::size_t> optimised;
  Sophus::SE3f optimum;
};
Calls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

}  // namespace

namespace ORB_SLAM3 {

// Takes every match for an inlier, and finds the pose that it is told to find.
int Optimizer::PoseOptimization(Frame* pFrame) {
  calls.optimised.clear();
  for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
    if (pFrame->mvpMapPoints[i] == nullptr) continue;
    pFrame->mvbOutlier[i] = false;
    calls.optimised.push_back(i);
  }
  pFrame->SetPose(calls.optimum);
  return static_cast<int>(calls.optimised.size());
}

int Optimizer::PoseInertialOptimizationLastKeyFrame(Frame* pFrame, bool /*bRecInit*/) {
  return PoseOptimization(pFrame);
}

}  // namespace ORB_SLAM3

namespace maxlogdet::test {
namespace {

using ORB_SLAM3::Frame;
using ORB_SLAM3::GeometricCamera;
using ORB_SLAM3::MapPoint;

class Pinhole : public GeometricCamera {
 public:
  Pinhole() : GeometricCamera({458, 457, 367, 248}, CAM_PINHOLE) {}
  Eigen::Vector2d project(const Eigen::Vector3d& p) override {
    return {458 * p.x() / p.z() + 367, 457 * p.y() / p.z() + 248};
  }
};

// The distance from the centre is an odd polynomial of the angle to the axis.
class KannalaBrandt8 : public GeometricCamera {
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
constexpr Sensor sensors[] = {Sensor::monocular, Sensor::stereo, Sensor::fisheye, Sensor::rig};

// `n` matches without noise at the true pose; every fifth one is off by 20 deviations. The frame's pose is a guess, at
// which all would be outliers. Empty slots between. Of a rig three matches of five are those of its right camera.
struct World {
  World(Random& random, std::size_t n, Sensor kind) : T_cw(random_pose(random)), sensor(kind) {
    calls = Calls();
    calls.optimum = in_float(T_cw);
    frame.mvScaleFactors = {1, 1.2F, 1.44F};
    frame.mpCamera =
        sensor == Sensor::fisheye || sensor == Sensor::rig ? static_cast<GeometricCamera*>(&fisheye) : &pinhole;
    frame.mbf = sensor == Sensor::stereo ? 50 : 0;
    if (sensor == Sensor::rig) {
      frame.mpCamera2 = &right_fisheye;
      sim::Vector6 xi;
      xi << -0.1, 0.02, 0.01, 0.1, -0.2, 0.05;
      T_rl = sim::exp_se3(xi);
      frame.mTrl = in_float(T_rl);
      frame.Nleft = static_cast<int>(n + n / 5) * 2 / 5;
    }
    for (std::size_t slot = 0, match = 0; match < n; ++slot) add_slot(random, slot, slot % 6 == 3 ? n : match++);
    frame.N = static_cast<int>(frame.mvpMapPoints.size());
    sim::Vector6 xi;
    xi << 0.3, 0.2, 0.3, 0.1, 0.1, 0.1;
    frame.SetPose(in_float(sim::exp_se3(xi) * T_cw));
  }

  static Sophus::SE3f in_float(const sim::Pose& T) { return {T.linear().cast<float>(), T.translation().cast<float>()}; }

  bool is_right(std::size_t slot) const { return sensor == Sensor::rig && static_cast<int>(slot) >= frame.Nleft; }

  // u, v and, in stereo, u_right, of a point in the frame of the left camera.
  Eigen::VectorXd measure(std::size_t slot, bool stereo, const Eigen::Vector3d& p) const {
    const Eigen::Vector2d uv = is_right(slot) ? frame.mpCamera2->project(T_rl * p) : frame.mpCamera->project(p);
    if (!stereo) return uv;
    return Eigen::Vector3d(uv.x(), uv.y(), uv.x() - frame.mbf / p.z());
  }

  MapPoint* new_point(const Eigen::Vector3d& in_camera) {
    points.push_back(std::make_unique<MapPoint>());
    points.back()->mnId = points.size();
    points.back()->mnFirstKFid = static_cast<long int>(points.size() / 50) - 1;
    points.back()->mWorldPos = (T_cw.inverse() * in_camera).cast<float>();
    return points.back().get();
  }

  // `match`: its number, or as many as there are for an empty slot.
  void add_slot(Random& random, std::size_t slot, std::size_t match) {
    const bool is_empty = slot % 6 == 3;
    const bool stereo = sensor == Sensor::stereo && match % 2 == 0;
    const Eigen::Vector3d p_c = random_point_in_camera(random);
    const Eigen::VectorXd z = measure(slot, stereo, p_c);
    cv::KeyPoint key;
    key.octave = static_cast<int>(match % 3);
    const double sigma = std::pow(1.2, key.octave);
    key.pt.x = static_cast<float>(z(0) + (match % 5 == 0 ? 20 * sigma : 0));
    key.pt.y = static_cast<float>(z(1));
    if (sensor != Sensor::rig) {
      frame.mvKeysUn.push_back(key);
      frame.mvuRight.push_back(stereo ? static_cast<float>(z(2)) : -1);
    } else {
      (is_right(slot) ? frame.mvKeysRight : frame.mvKeys).push_back(key);
    }
    frame.mvpMapPoints.push_back(is_empty ? nullptr : new_point(p_c));
    frame.mvbOutlier.push_back(random.chance(0.5));
    is_outlier.push_back(match % 5 == 0);
  }

  Eigen::Vector3d in_frame(const MapPoint& point) const { return (frame.GetPose() * point.mWorldPos).cast<double>(); }

  // In the order of the slots that are not empty.
  std::vector<Matrix6> informations() const {
    std::vector<Matrix6> all;
    std::size_t match = 0;
    for (std::size_t slot = 0; slot < frame.mvpMapPoints.size(); ++slot) {
      if (frame.mvpMapPoints[slot] == nullptr) continue;
      const bool stereo = sensor == Sensor::stereo && frame.mvuRight[slot] >= 0;
      const Eigen::MatrixXd H_x = derivative_under_left_perturbation(
          [&](const Eigen::Vector3d& p) { return measure(slot, stereo, p); }, in_frame(*frame.mvpMapPoints[slot]));
      all.emplace_back(gram(H_x) / std::pow(1.2, 2 * static_cast<double>(match++ % 3)));
    }
    return all;
  }

  sim::Pose T_cw;
  sim::Pose T_rl = sim::Pose::Identity();
  Sensor sensor;
  mutable Pinhole pinhole;
  mutable KannalaBrandt8 fisheye{-0.01F}, right_fisheye{0.02F};
  Frame frame;
  std::vector<std::unique_ptr<MapPoint>> points;
  std::vector<bool> is_outlier;  // of each slot
};

TEST(OrbSlam3Adapter, blocks_are_derivatives_of_the_projection_under_a_left_perturbation) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : sensors) {
    SCOPED_TRACE(static_cast<int>(sensor));
    World world(random, 100, sensor);
    const std::vector<Matrix6> expected = world.informations();
    OrbSlam3 good(20);
    good.optimize(world.frame, ORB_SLAM3::Optimizer::PoseOptimization);
    ASSERT_EQ(good.features.blocks().size(), 100U);
    for (std::size_t i = 0; i < 100; ++i) {
      ASSERT_TRUE(good.features.blocks().is_valid(i)) << i;
      EXPECT_LT(relative_difference(gram(stored_block(good.features.blocks(), i)), expected[i]), 1e-4) << i;
    }
  }
}

TEST(OrbSlam3Adapter, matches_come_back_with_flags_by_the_frames_own_cameras_at_the_new_pose) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : sensors) {
    for (const bool is_inertial : {false, true}) {
      SCOPED_TRACE(static_cast<int>(sensor));
      World world(random, 300, sensor);
      ORB_SLAM3::Tracking tracking;
      tracking.mCurrentFrame = world.frame;
      tracking.TrackLocalMap(is_inertial);
      EXPECT_EQ(calls.optimised.size(), 200U);
      EXPECT_EQ(tracking.mCurrentFrame.mvpMapPoints, world.frame.mvpMapPoints);
      const std::set<std::size_t> selected(calls.optimised.begin(), calls.optimised.end());
      for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
        if (world.frame.mvpMapPoints[i] == nullptr || selected.count(i) > 0) continue;
        EXPECT_EQ(tracking.mCurrentFrame.mvbOutlier[i], world.is_outlier[i]) << i;
      }
    }
  }
}

TEST(OrbSlam3Adapter, inliers_are_those_of_the_optimiser_and_those_that_it_was_not_given) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : sensors) {
    World world(random, 300, sensor);
    OrbSlam3 good(100);
    const int inliers = good.optimize(world.frame, ORB_SLAM3::Optimizer::PoseOptimization);
    int expected = 0;
    for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
      if (world.frame.mvpMapPoints[i] != nullptr && !world.frame.mvbOutlier[i]) ++expected;
    }
    EXPECT_EQ(inliers, expected);
    EXPECT_GT(inliers, 200);
  }
}

TEST(OrbSlam3Adapter, a_frame_without_a_pose_is_optimised_with_all_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : sensors) {
    World world(random, 300, sensor);
    world.frame.mbIsSet = false;
    OrbSlam3 good(100);
    good.optimize(world.frame, ORB_SLAM3::Optimizer::PoseOptimization);
    EXPECT_EQ(calls.optimised.size(), 300U);
    EXPECT_STREQ(good.cost().status, "invalid_pose");
  }
}

// Keyframes nearby: a pinhole that sees in stereo, a pinhole, one of a rig, a bad one, and one whose right camera alone
// sees. Only the first two count.
std::vector<ORB_SLAM3::KeyFrame> keyframes_near(Random& random, World& world) {
  std::vector<ORB_SLAM3::KeyFrame> keyframes(5);
  for (ORB_SLAM3::KeyFrame& keyframe : keyframes) {
    sim::Vector6 xi;
    xi << random_vector(random, 0.4), random_vector(random, 0.05);
    keyframe.mTcw = World::in_float(sim::exp_se3(xi) * world.T_cw);
    keyframe.mbf = 50;
    keyframe.mvScaleFactors = world.frame.mvScaleFactors;
  }
  keyframes[2].mpCamera2 = &world.fisheye;
  keyframes[3].mbBad = true;
  return keyframes;
}

// Lets all keyframes observe the point, (left, right) with -1 for none; the information of those that count.
Eigen::Matrix3d observe(Random& random, std::vector<ORB_SLAM3::KeyFrame>& keyframes, int index, MapPoint& point) {
  Eigen::Matrix3d information = 1e-6 * Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    ORB_SLAM3::KeyFrame& keyframe = keyframes[k];
    const bool right_only = k == 4;
    point.mObservations[&keyframe] = std::make_tuple(right_only ? -1 : index, right_only ? 3 : -1);
    point.nObs += 1;
    cv::KeyPoint key;
    key.octave = random.integer(0, 2);
    const bool stereo = k == 0;
    keyframe.mvKeysUn.push_back(key);
    keyframe.mvuRight.push_back(stereo ? 100.0F : -1.0F);
    if (k > 1) continue;
    const Eigen::Vector3d p = (keyframe.mTcw * point.mWorldPos).cast<double>();
    const Eigen::MatrixXd H_p = Derivatives({p, stereo ? 50.0 : 0.0, 458, 457}).H_p.topRows(stereo ? 3 : 2);
    information += std::pow(1.2, -2 * key.octave) * gram(H_p * keyframe.mTcw.rotationMatrix().cast<double>());
  }
  return information;
}

// Keyframes of a rig are left out, and bad ones.
TEST(OrbSlam3Adapter, covariances_are_what_the_pinhole_keyframes_leave) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 60, Sensor::monocular);
  std::vector<ORB_SLAM3::KeyFrame> keyframes = keyframes_near(random, world);
  std::vector<SeenPoint> expected;
  const Eigen::Matrix3d R_cw = world.frame.GetPose().rotationMatrix().cast<double>();
  for (std::size_t i = 0; i < world.points.size(); ++i) {
    MapPoint& point = *world.points[i];
    const Eigen::Matrix3d information = observe(random, keyframes, static_cast<int>(i), point);
    expected.push_back({world.in_frame(point), 0, 458, 457, std::pow(1.2, static_cast<double>(i % 3)),
                        R_cw * inverse(information) * R_cw.transpose()});
  }
  OrbSlam3 good(20);
  good.use_covariances = true;
  good.optimize(world.frame, ORB_SLAM3::Optimizer::PoseOptimization);
  EXPECT_LT(largest_difference(good.features.blocks(), expected), 1e-3);
}

// The keypoint of a slot as the frame has it.
const cv::KeyPoint& key_of(const World& world, std::size_t slot) {
  const Frame& frame = world.frame;
  if (world.sensor != Sensor::rig) return frame.mvKeysUn[slot];
  const auto left = static_cast<std::size_t>(frame.Nleft);
  return slot < left ? frame.mvKeys[slot] : frame.mvKeysRight[slot - left];
}

TEST(OrbSlam3Adapter, a_recorded_frame_has_the_matches_of_every_camera_as_they_were_before_the_optimisation) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : sensors) {
    SCOPED_TRACE(static_cast<int>(sensor));
    World world(random, 300, sensor);
    const TemporaryFolder folder;
    OrbSlam3 good(100);
    ASSERT_TRUE(good.record(folder.path().c_str()));
    const RigidTransform T_cw = RigidTransform(world.frame.GetPose().matrix3x4());
    good.optimize(world.frame, ORB_SLAM3::Optimizer::PoseOptimization);
    const RecordedFrame recorded(folder / "frame_000000.csv");
    EXPECT_EQ(recorded.numbers("Tcw_prior"), std::vector<double>(T_cw.data(), T_cw.data() + 12));
    ASSERT_EQ(recorded.rows.size(), 300U);
    if (sensor == Sensor::rig) {
      EXPECT_EQ(recorded.numbers("camera 1", 1)[4], static_cast<double>(0.02F));
      EXPECT_EQ(recorded.numbers("T_cb 1").size(), 12U);
    }
    EXPECT_EQ(recorded.comments.count("camera"), sensor == Sensor::fisheye ? 1U : 0U);
    EXPECT_EQ(recorded.comments.count("fx,fy,cx,cy,bf"), sensor == Sensor::rig || sensor == Sensor::fisheye ? 0U : 1U);
    for (std::size_t row = 0; row < 300; ++row) {
      const auto slot = static_cast<std::size_t>(recorded.at(row, "kp"));
      const MapPoint& point = *world.frame.mvpMapPoints[slot];
      EXPECT_EQ(recorded.at(row, "mp_id"), static_cast<double>(point.mnId));
      EXPECT_EQ(recorded.at(row, "keyframe"), static_cast<double>(point.mnFirstKFid));
      EXPECT_EQ(recorded.at(row, "Z"), static_cast<double>(point.mWorldPos.z()));
      EXPECT_EQ(recorded.at(row, "u"), static_cast<double>(key_of(world, slot).pt.x));
      EXPECT_EQ(recorded.at(row, "v"), static_cast<double>(key_of(world, slot).pt.y));
      EXPECT_EQ(recorded.at(row, "selected"), good.features.is_selected(row) ? 1 : 0);
      if (sensor == Sensor::rig) {
        EXPECT_EQ(recorded.at(row, "camera"), world.is_right(slot) ? 1 : 0);
      }
      if (sensor == Sensor::stereo) {
        const float u_right = world.frame.mvuRight[slot];
        EXPECT_EQ(recorded.at(row, "u_right"), u_right >= 0 ? static_cast<double>(u_right) : -1);
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
