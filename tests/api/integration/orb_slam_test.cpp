// SPDX-License-Identifier: MIT
// The adapters of ORB-SLAM2 and ORB-SLAM3 and the lines of docs/trackers.md for them: flags of the matches that the
// optimiser was not given. The trackers differ in the types of poses and points, and in their cameras.
#include "tests/api/integration/adapter_world.hpp"
#include "tests/api/integration/guide.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/camera_oracle.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <opencv2/core/eigen.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace maxlogdet::test {
namespace {

using Slam2 = ORB_SLAM2::Tracking;
using Slam3 = ORB_SLAM3::Tracking;

// What the stand-ins' optimisers were asked for, and what they are to find.
struct OrbCalls {
  std::vector<std::size_t> optimised;  // slots whose map points entered the optimiser
  Eigen::MatrixXd optimum;             // 4 x 4
};
OrbCalls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

// Matrices of the trackers' types, in float, from those of Eigen and back.
void set(cv::Mat& to, const Eigen::MatrixXd& from) { cv::eigen2cv(Eigen::MatrixXf(from.cast<float>()), to); }
void set(Sophus::SE3f& to, const Eigen::MatrixXd& from) {
  const Eigen::MatrixXf T = from.cast<float>();
  to = Sophus::SE3f(Eigen::Matrix3f(T.topLeftCorner<3, 3>()), T.block<3, 1>(0, 3));
}
void set(Eigen::Vector3f& to, const Eigen::MatrixXd& from) { to = from.cast<float>(); }

Eigen::MatrixXd get(const cv::Mat& from) {
  Eigen::MatrixXd to;
  cv::cv2eigen(from, to);
  return to;
}
Eigen::MatrixXd get(const Sophus::SE3f& from) { return from.matrix3x4().cast<double>(); }
Eigen::MatrixXd get(const Eigen::Vector3f& from) { return from.cast<double>(); }
template <class Pose>
sim::Pose pose_of(const Pose& from) {
  sim::Pose T = sim::Pose::Identity();
  T.matrix().topRows<3>() = get(from).topRows(3);
  return T;
}

// Takes every match that is not null for an inlier, whatever its flag, and finds the pose that it is told to find.
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

// For tests of what is selected, at the pose of the frame.
template <class Frame>
int no_optimization(Frame* /*frame*/) {
  return 0;
}

// Of a fisheye, the distance from the centre is an odd polynomial of the angle to the axis.
Eigen::Vector2d project(const ORB_SLAM3::GeometricCamera& camera, const Eigen::Vector3d& p) {
  const auto parameter = [&](std::size_t i) { return double{camera.mvParameters[i]}; };
  const double radius = std::hypot(p.x(), p.y()), theta = std::atan2(radius, p.z());
  double distance = theta;
  for (std::size_t i = 4; i < camera.mvParameters.size(); ++i) {
    distance += parameter(i) * std::pow(theta, 2 * static_cast<double>(i) - 5);
  }
  const double scale = camera.mnType == 1 ? distance / radius : 1 / p.z();
  return {parameter(0) * scale * p.x() + parameter(2), parameter(1) * scale * p.y() + parameter(3)};
}

// ORB-SLAM2 knows the first two.
enum class Sensor { monocular, stereo, fisheye, rig };

// Matches without noise at the true pose; every fifth one is off by 20 deviations. The frame's pose is a guess, at
// which all would be outliers. Every sixth slot is empty; flags are left over from before. In stereo every second match
// has a right column; of a rig three matches of five are those of its right camera.
template <class Tracking>
class OrbWorld : public AdapterWorld {
 public:
  static constexpr bool is_slam3 = std::is_same<Tracking, Slam3>::value;
  using Adapter = decltype(Tracking::mGoodFeatures);
  using Frame = decltype(Tracking::mCurrentFrame);
  using MapPoint = std::remove_pointer_t<typename decltype(Frame::mvpMapPoints)::value_type>;

  OrbWorld(Random& random, std::size_t n, std::size_t budget, std::size_t capacity, Sensor of = Sensor::monocular)
      : sensor(of), T_cw(random_pose(random, 2, 0.9)), n_(n) {
    calls = {{}, T_cw.matrix()};
    good = Adapter(budget, capacity);
    good.features.rejects_outliers = false;  // selection among all, at the frame's pose
    frame.mvScaleFactors = {1, 1.2F, 1.44F};
    frame.mbf = sensor == Sensor::stereo ? 50 : 0;
    while (slots.size() < n) add_slot(random);
    if constexpr (is_slam3) set_cameras();
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
    const sim::Pose T = pose_of(frame.mTcw);
    for (std::size_t i = 0; i < n_; ++i) {
      const auto measured = [this, i](const Eigen::Vector3d& p) { return measure(i, p); };
      all.push_back({measured, T * position_of(i), sigma_of(i)});
    }
    return all;
  }

  void lose_pose() override {
    if constexpr (is_slam3) {
      frame.mbIsSet = false;
    } else {
      frame.mTcw = cv::Mat();
    }
  }
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

  Sensor sensor;
  Tracking tracking;
  Adapter& good = tracking.mGoodFeatures;
  Frame& frame = tracking.mCurrentFrame;
  sim::Pose T_cw;
  std::vector<std::size_t> slots;  // of the matches
  std::vector<cv::KeyPoint> keys;  // of the matches
  std::vector<std::unique_ptr<MapPoint>> points;
  ORB_SLAM3::GeometricCamera pinhole = {{458, 457, 367, 248}, 0};
  ORB_SLAM3::GeometricCamera fisheye = {{190, 191, 255, 256, -0.01F, -0.002F, 0.001F, -0.0003F}, 1};
  ORB_SLAM3::GeometricCamera right_fisheye = {{190, 191, 255, 256, 0.02F, -0.002F, 0.001F, -0.0003F}, 1};
  ORB_SLAM3::GeometricCamera* const left = sensor == Sensor::fisheye || sensor == Sensor::rig ? &fisheye : &pinhole;
  sim::Pose T_rl = sim::exp_se3((sim::Vector6() << -0.1, 0.02, 0.01, 0.1, -0.2, 0.05).finished());

 private:
  void set_cameras() {
    frame.mpCamera = left;
    if (sensor != Sensor::rig) return;
    frame.mpCamera2 = &right_fisheye;
    frame.Nleft = static_cast<int>(frame.mvKeys.size());
    set(frame.mTrl, T_rl.matrix());
  }
  std::vector<cv::KeyPoint>& keys_of_camera_of(std::size_t i) {
    if constexpr (is_slam3) {
      if (sensor == Sensor::rig) return is_right(i) ? frame.mvKeysRight : frame.mvKeys;
    }
    return frame.mvKeysUn;
  }

  // Where a match's camera sees a point in the frame of the left camera; u, v and, in stereo, u_right.
  Eigen::Vector2d project_by_camera_of(std::size_t i, const Eigen::Vector3d& p) const {
    return is_right(i) ? project(right_fisheye, T_rl * p) : project(*left, p);
  }
  Eigen::VectorXd measure(std::size_t i, const Eigen::Vector3d& p) const {
    const Eigen::Vector2d uv = project_by_camera_of(i, p);
    if (!is_stereo(i)) return uv;
    return Eigen::Vector3d(uv.x(), uv.y(), uv.x() - frame.mbf / p.z());
  }

  void add_slot(Random& random) {
    const bool is_empty = frame.mvpMapPoints.size() % 6 == 3;
    const std::size_t i = slots.size();
    const Eigen::Vector3d p_c = random_point_in_camera(random);
    const Eigen::Vector2d uv = project_by_camera_of(i, p_c);
    cv::KeyPoint key;
    key.octave = static_cast<int>(i % 3);
    key.pt.x = static_cast<float>(uv.x() + (is_wrong(i) ? 20 * sigma_of(i) : 0));
    key.pt.y = static_cast<float>(uv.y());
    keys_of_camera_of(i).push_back(key);
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
    frame.mvpMapPoints.back() = &made;
  }

  std::size_t n_;
};

template <class Slam, Sensor sensor>
std::unique_ptr<AdapterWorld> make_world(Random& random, std::size_t n, std::size_t budget, std::size_t capacity) {
  return std::make_unique<OrbWorld<Slam>>(random, n, budget, capacity, sensor);
}

constexpr AdapterCase of_orb_slam[] = {{"OrbSlam2Monocular", make_world<Slam2, Sensor::monocular>, 1e-4},
                                       {"OrbSlam2Stereo", make_world<Slam2, Sensor::stereo>, 1e-4},
                                       {"OrbSlam3Monocular", make_world<Slam3, Sensor::monocular>, 1e-4},
                                       {"OrbSlam3Stereo", make_world<Slam3, Sensor::stereo>, 1e-4},
                                       {"OrbSlam3Fisheye", make_world<Slam3, Sensor::fisheye>, 1e-4},
                                       {"OrbSlam3Rig", make_world<Slam3, Sensor::rig>, 1e-4}};
INSTANTIATE_TEST_SUITE_P(OrbSlam, AnyAdapter, ::testing::ValuesIn(of_orb_slam), name_of);

// Tests of both, by their types.
template <class Slam>
class OrbSlamAdapter : public ::testing::Test {
 protected:
  using Frame = typename OrbWorld<Slam>::Frame;
  TracedRandom random;
};
using Slams = ::testing::Types<Slam2, Slam3>;
struct SlamNames {
  template <class Slam>
  static std::string GetName(int /*number*/) {
    return std::is_same<Slam, Slam2>::value ? "OrbSlam2" : "OrbSlam3";
  }
};
TYPED_TEST_SUITE(OrbSlamAdapter, Slams, SlamNames);

// The guess at which the frame was selected would make all matches outliers.
TYPED_TEST(OrbSlamAdapter, matches_come_back_with_flags_by_the_frames_own_cameras_at_the_new_pose) {
  using World = OrbWorld<TypeParam>;
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::fisheye, Sensor::rig}) {
    if (!World::is_slam3 && sensor > Sensor::stereo) continue;
    SCOPED_TRACE(static_cast<int>(sensor));
    World world(this->random, 400, 200, 400, sensor);
    const std::set<std::size_t> optimised = world.run();
    EXPECT_EQ(optimised.size(), 200U);
    for (std::size_t i = 0; i < 400; ++i) {
      EXPECT_EQ(world.is_outlier(i), world.is_wrong(i) && optimised.count(i) == 0) << i;
    }
  }
}

// Far from the guess: without noise the pose is that of the measurements, in float32.
template <class World, class Frame>
void expect_true_pose(const World& world, const Frame& frame) {
  EXPECT_LT(relative_difference(pose_of(frame.mTcw).matrix(), world.T_cw.matrix()), 1e-5);
}

TYPED_TEST(OrbSlamAdapter, alignment_alone_sets_the_pose_and_flags_the_wrong_matches) {
  OrbWorld<TypeParam> world(this->random, 300, 100, 300);
  int optimised = 0;
  const auto optimize = [&](const typename TestFixture::Frame* frame) {
    EXPECT_EQ(frame, &world.frame);
    ++optimised;
    return 7;
  };
  EXPECT_EQ(world.good.align(world.frame, optimize), 240);
  EXPECT_TRUE(world.good.features.alignment().is_aligned());
  expect_true_pose(world, world.frame);
  for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(world.is_outlier(i), world.is_wrong(i)) << i;
  typename OrbWorld<TypeParam>::Adapter small(100, 200);
  EXPECT_EQ(small.align(world.frame, optimize), 160) << "of the first 200";
  EXPECT_EQ(optimised, 0);
}

// After an error, and where no pose fits.
TYPED_TEST(OrbSlamAdapter, the_optimiser_does_as_before_what_cannot_be_aligned) {
  OrbWorld<TypeParam> world(this->random, 300, 100, 300);
  const std::vector<bool> flags = world.frame.mvbOutlier;
  const auto before = world.frame.mvpMapPoints;
  const auto optimize = [&](const typename TestFixture::Frame* frame) {
    EXPECT_EQ(frame, &world.frame);
    return 7;
  };
  typename OrbWorld<TypeParam>::Adapter small(5, 9);
  EXPECT_EQ(small.align(world.frame, optimize), 7);
  EXPECT_STREQ(small.features.alignment().reason(), "few_matches");
  EXPECT_EQ(world.frame.mvbOutlier, flags);
  const auto optimize_all = [&](const typename TestFixture::Frame* frame) {
    EXPECT_EQ(frame->mvpMapPoints, before);
    return 7;
  };
  EXPECT_EQ(small.optimize(world.frame, optimize_all), 7) << "nothing was left out";
  world.lose_pose();
  EXPECT_EQ(world.good.align(world.frame, optimize), 7);
  EXPECT_STREQ(world.good.features.alignment().reason(), "invalid_pose");
}

// Matches come back also if it throws.
TYPED_TEST(OrbSlamAdapter, the_optimiser_starts_at_the_aligned_pose_with_inliers_alone) {
  OrbWorld<TypeParam> world(this->random, 300, 100, 300);
  world.good.features.rejects_outliers = true;
  const auto before = world.frame.mvpMapPoints;
  int given = 0;
  const auto optimize = [&](const typename TestFixture::Frame* frame) -> int {
    expect_true_pose(world, *frame);
    for (std::size_t i = 0; i < 300; ++i) {
      if (frame->mvpMapPoints[world.slots[i]] == nullptr) continue;
      ++given;
      EXPECT_FALSE(world.is_wrong(i)) << i;
    }
    if (given > 100) throw std::runtime_error("no convergence");
    return given;
  };
  EXPECT_EQ(world.good.optimize(world.frame, optimize), 240);
  EXPECT_EQ(given, 100);
  EXPECT_THROW(world.good.optimize(world.frame, optimize), std::runtime_error);
  EXPECT_EQ(given, 200);
  EXPECT_EQ(world.frame.mvpMapPoints, before);
}

TYPED_TEST(OrbSlamAdapter, nothing_but_the_trackers_map_points_allocates_in_a_frame) {
  if (allocations() < 0) GTEST_SKIP() << "allocations cannot be counted here";
  OrbWorld<TypeParam> world(this->random, 400, 100, 400);
  const long copies = allocations_in([&] {
    for (std::size_t i = 0; i < 400; ++i) world.point(i).GetWorldPos();
  });
  const auto optimize = [&] { world.good.optimize(world.frame, no_optimization<typename TestFixture::Frame>); };
  EXPECT_EQ(allocations_in(optimize), copies);
}

}  // namespace
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

}  // namespace ORB_SLAM3
