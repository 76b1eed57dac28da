// SPDX-License-Identifier: MIT
// The adapters of ORB-SLAM2 and ORB-SLAM3 and the guide's lines for them: flags of the matches that the optimiser was
// not given, weights of edges, and the covariances of map points that the adapters keep.
#include "tests/api/integration/orb_slam_world.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/recording.hpp"

#include <stdexcept>
#include <string>
#include <type_traits>

namespace maxlogdet::test {
namespace {

// By the frame's own camera.
template <class Slam, Sensor sensor>
class WorldOf : public OrbWorld<Slam> {
 public:
  WorldOf(Random& random, std::size_t n, std::size_t budget, std::size_t capacity)
      : OrbWorld<Slam>(random, n, budget, capacity, sensor) {}
};

constexpr AdapterCase of_orb_slam[] = {{"OrbSlam2Monocular", make_world<WorldOf<Slam2, Sensor::monocular>>, 1e-4},
                                       {"OrbSlam2Stereo", make_world<WorldOf<Slam2, Sensor::stereo>>, 1e-4},
                                       {"OrbSlam3Monocular", make_world<WorldOf<Slam3, Sensor::monocular>>, 1e-4},
                                       {"OrbSlam3Stereo", make_world<WorldOf<Slam3, Sensor::stereo>>, 1e-4},
                                       {"OrbSlam3Fisheye", make_world<WorldOf<Slam3, Sensor::fisheye>>, 1e-4},
                                       {"OrbSlam3Rig", make_world<WorldOf<Slam3, Sensor::rig>>, 1e-4}};
INSTANTIATE_TEST_SUITE_P(OrbSlam, AnyAdapter, ::testing::ValuesIn(of_orb_slam), name_of);

// Tests of both, by their types.
template <class Slam>
class OrbSlamAdapter : public ::testing::Test {
 protected:
  Random random;
  ::testing::ScopedTrace trace{__FILE__, __LINE__, random.name()};
};
using Slams = ::testing::Types<Slam2, Slam3>;
struct SlamNames {
  template <class Slam>
  static std::string GetName(int /*number*/) {
    return std::is_same<Slam, Slam2>::value ? "OrbSlam2" : "OrbSlam3";
  }
};
TYPED_TEST_SUITE(OrbSlamAdapter, Slams, SlamNames);

// Of what was not selected; the guess at which the frame was selected would make all outliers.
template <class Frame, class World>
void expect_flags(const World& world, const Frame& tracked) {
  const std::set<std::size_t> optimised(calls.optimised.begin(), calls.optimised.end());
  for (std::size_t i = 0; i < world.slots.size(); ++i) {
    const std::size_t slot = world.slots[i];
    EXPECT_EQ(tracked.mvbOutlier[slot], world.is_wrong(i) && optimised.count(slot) == 0) << i;
  }
}

TEST(OrbSlam2Adapter, tracking_counts_all_inliers_not_only_the_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo}) {
    OrbWorld<Slam2> world(random, 400, 200, 400, sensor);
    ORB_SLAM2::Tracking tracking;
    tracking.mCurrentFrame = world.frame;
    EXPECT_TRUE(tracking.TrackLocalMap());
    EXPECT_EQ(calls.optimised.size(), 200U);
    EXPECT_EQ(tracking.mCurrentFrame.mvpMapPoints, world.frame.mvpMapPoints);
    expect_flags(world, tracking.mCurrentFrame);
    int found = 0;
    for (const auto& point : world.points) found += point->mnFound - 1;
    EXPECT_EQ(found, tracking.mnMatchesInliers);
    EXPECT_GT(found, 300);
  }
}

TEST(OrbSlam3Adapter, matches_come_back_with_flags_by_the_frames_own_cameras_at_the_new_pose) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::fisheye, Sensor::rig}) {
    for (const bool is_inertial : {false, true}) {
      SCOPED_TRACE(static_cast<int>(sensor));
      OrbWorld<Slam3> world(random, 300, 200, 300, sensor);
      ORB_SLAM3::Tracking tracking;
      tracking.mCurrentFrame = world.frame;
      tracking.TrackLocalMap(is_inertial);
      EXPECT_EQ(calls.optimised.size(), 200U);
      EXPECT_EQ(tracking.mCurrentFrame.mvpMapPoints, world.frame.mvpMapPoints);
      expect_flags(world, tracking.mCurrentFrame);
    }
  }
}

// Far from the guess: without noise the pose is that of the measurements, in float32.
template <class Slam>
void expect_true_pose(const OrbWorld<Slam>& world, const typename Slam::Frame& frame) {
  EXPECT_LT(relative_difference(Slam::pose_of(frame).matrix(), world.T_cw.matrix()), 1e-5);
}

TYPED_TEST(OrbSlamAdapter, alignment_alone_sets_the_pose_and_flags_the_wrong_matches) {
  OrbWorld<TypeParam> world(this->random, 300, 100, 300);
  EXPECT_EQ(world.good.align(world.frame), 240);
  EXPECT_STREQ(world.good.cost().status, "aligned");
  expect_true_pose(world, world.frame);
  for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(world.is_outlier(i), world.is_wrong(i)) << i;
  typename TypeParam::Adapter small(100, 200);
  EXPECT_EQ(small.align(world.frame), 160) << "of the first 200";
  small.features.block_options.min_depth = -1;
  EXPECT_EQ(small.align(world.frame), 0);
  EXPECT_STREQ(small.cost().status, "invalid_block_options");
  TypeParam::forget_pose(world.frame);
  EXPECT_EQ(world.good.align(world.frame), 0);
  EXPECT_STREQ(world.good.cost().status, "invalid_pose");
  for (std::size_t i = 0; i < 300; ++i) EXPECT_TRUE(world.is_outlier(i)) << i;
}

TYPED_TEST(OrbSlamAdapter, the_optimiser_starts_at_the_aligned_pose_with_inliers_alone) {
  OrbWorld<TypeParam> world(this->random, 300, 100, 300);
  world.good.features.rejects_outliers = true;
  const auto expect_aligned = [&](const typename TypeParam::Frame* frame) {
    expect_true_pose(world, *frame);
    std::size_t given = 0;
    for (std::size_t i = 0; i < 300; ++i) {
      if (frame->mvpMapPoints[world.slots[i]] == nullptr) continue;
      ++given;
      EXPECT_FALSE(world.is_wrong(i)) << i;
    }
    EXPECT_EQ(given, 100U);
    return 100;
  };
  EXPECT_EQ(world.good.optimize(world.frame, expect_aligned), 240);
}

TYPED_TEST(OrbSlamAdapter, matches_come_back_if_the_optimiser_throws) {
  OrbWorld<TypeParam> world(this->random, 300, 100, 300);
  const auto before = world.frame.mvpMapPoints;
  const auto fail = [&](typename TypeParam::Frame* frame) -> int {
    EXPECT_NE(frame->mvpMapPoints, before);
    throw std::runtime_error("no convergence");
  };
  EXPECT_THROW(world.good.optimize(world.frame, fail), std::runtime_error);
  EXPECT_EQ(world.frame.mvpMapPoints, before);
}

TYPED_TEST(OrbSlamAdapter, nothing_but_the_trackers_map_points_allocates_in_a_frame) {
  if (allocations() < 0) GTEST_SKIP() << "allocations cannot be counted here";
  OrbWorld<TypeParam> world(this->random, 400, 100, 400);
  const auto keep_the_pose = [](const typename TypeParam::Frame* /*frame*/) { return 100; };
  const long copies = allocations_in([&] {
    for (std::size_t i = 0; i < 400; ++i) world.point(i).GetWorldPos();
  });
  EXPECT_EQ(allocations_in([&] { world.good.optimize(world.frame, keep_the_pose); }), copies);
}

// Sigma = Sigma_z + J Sigma_p J^T of the selected matches, whose slots are not their numbers; without covariances what
// the octave says.
TEST(OrbSlam2Adapter, edges_weigh_what_the_blocks_do) {
  Random random;
  SCOPED_TRACE(random.name());
  OrbWorld<Slam2> world(random, 300, 200, 300, Sensor::stereo);
  for (const bool use_covariances : {false, true}) {
    ORB_SLAM2::weighted::Tracking tracking;
    tracking.mCurrentFrame = world.frame;
    tracking.mGoodFeatures.use_covariances = use_covariances;
    tracking.mGoodFeatures.features.is_weighted = true;
    tracking.mGoodFeatures.features.rejects_outliers = false;
    tracking.TrackLocalMap();
    EXPECT_GT(calls.weights.size(), 10U);
    for (std::size_t i = 0; i < 300; ++i) {
      if (calls.weights.count(world.slots[i]) == 0) continue;
      const SeenPoint seen = world.seen(i, use_covariances);
      const Derivatives derivatives(seen);
      const Eigen::MatrixXd map = product(product(derivatives.H_p, seen.covariance), derivatives.H_p.transpose());
      const Eigen::MatrixXd Sigma = map + seen.sigma * seen.sigma * Eigen::Matrix3d::Identity();
      EXPECT_LT(relative_difference(calls.weights[world.slots[i]], inverse(Sigma)), 1e-4) << i;
    }
    double untouched[9] = {-7};
    EXPECT_FALSE(tracking.mGoodFeatures.information(3, untouched)) << "an empty slot";
    EXPECT_FALSE(tracking.mGoodFeatures.information(world.frame.mvpMapPoints.size(), untouched));
    EXPECT_EQ(untouched[0], -7);
  }
}

TEST(OrbSlamAdapters, a_recorded_frame_names_its_cameras_and_the_pose_before_the_optimisation) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::fisheye, Sensor::rig}) {
    SCOPED_TRACE(static_cast<int>(sensor));
    OrbWorld<Slam3> world(random, 30, 10, 30, sensor);
    const TemporaryFolder folder;
    ASSERT_TRUE(world.good.record(folder.path().c_str()));
    const RigidTransform T_cw(world.frame.GetPose().matrix3x4());
    world.run();
    const RecordedFrame recorded(folder / "frame_000000.csv");
    EXPECT_EQ(recorded.numbers("Tcw_prior"), std::vector<double>(T_cw.data(), T_cw.data() + 12));
    EXPECT_EQ(recorded.comments.count("camera"), sensor == Sensor::fisheye ? 1U : 0U);
    if (sensor == Sensor::rig) {
      EXPECT_EQ(recorded.numbers("camera 1", 1)[4], static_cast<double>(0.02F));
      EXPECT_EQ(recorded.numbers("T_cb 1").size(), 12U);
    } else if (sensor != Sensor::fisheye) {
      EXPECT_EQ(recorded.numbers("fx,fy,cx,cy,bf"),
                (std::vector<double>{458, 457, 367, 248, sensor == Sensor::stereo ? 50.0 : 0.0}));
    }
  }
}

// Without an edit of MapPoint. Those of a frame are kept: local bundle adjustment moves a point by little, a new
// observation adds much.
TYPED_TEST(OrbSlamAdapter, covariances_are_recomputed_when_the_number_of_observations_changes) {
  OrbWorld<TypeParam> world(this->random, 100, 20, 100, Sensor::stereo);
  world.good.use_covariances = true;
  const auto no_optimization = [](typename TypeParam::Frame* /*frame*/) { return 0; };
  const auto difference_from = [&](const std::vector<SeenPoint>& points) {
    world.good.optimize(world.frame, no_optimization);
    return largest_difference(world.good.features.blocks(), points);
  };
  const std::vector<SeenPoint> before = world.all_seen();
  EXPECT_LT(difference_from(before), 1e-4);

  TypeParam::set_pose(world.keyframes[0], world.near(this->random, 3, 0.1));
  EXPECT_LT(difference_from(before), 1e-4) << "kept";
  for (const auto& point : world.points) world.observe(this->random, *point, world.keyframes[1], true);
  EXPECT_LT(difference_from(world.all_seen()), 1e-4) << "recomputed";
  EXPECT_GT(difference_from(before), 1e-2) << "the change is too small for this test";

  world.keyframes[0].mbBad = true;
  for (const auto& point : world.points) --point->nObs;
  EXPECT_LT(difference_from(world.all_seen()), 1e-4) << "a bad keyframe does not count";

  for (const auto& point : world.points) {  // by more than half a standard deviation, as when a map is scaled
    TypeParam::set_position(*point, world.T_cw.inverse() * (5 * (world.T_cw * TypeParam::position_of(*point))));
  }
  EXPECT_LT(difference_from(world.all_seen()), 1e-4) << "recomputed where the map has moved";
}

TEST(OrbSlam3Adapter, keyframes_of_rigs_and_what_right_cameras_alone_see_do_not_count) {
  Random random;
  SCOPED_TRACE(random.name());
  OrbWorld<Slam3> world(random, 60, 20, 60);
  world.good.use_covariances = true;
  const std::vector<SeenPoint> expected = world.all_seen();
  ORB_SLAM3::KeyFrame of_rig = world.keyframes[0], of_right = world.keyframes[0];
  of_rig.mpCamera2 = &world.cameras->fisheye;
  for (const auto& point : world.points) {
    point->mObservations[&of_rig] = std::make_tuple(0, -1);
    point->mObservations[&of_right] = std::make_tuple(-1, 3);
  }
  world.good.optimize(world.frame, [](ORB_SLAM3::Frame* /*frame*/) { return 0; });
  EXPECT_LT(largest_difference(world.good.features.blocks(), expected), 1e-4);
}

// The trackers make map points of the last frame for the next one alone; no keyframe has seen them.
TYPED_TEST(OrbSlamAdapter, a_point_without_observations_has_the_map_deviation_of_the_options) {
  OrbWorld<TypeParam> world(this->random, 50, 20, 50, Sensor::stereo);
  world.point(7).mObservations.clear();
  world.point(7).nObs = 0;
  world.good.use_covariances = true;
  world.good.features.block_options.map_sigma = 0.2;
  std::vector<SeenPoint> expected = world.all_seen();
  expected[7].covariance = 0.04 * Eigen::Matrix3d::Identity();
  world.good.optimize(world.frame, [](typename TypeParam::Frame* /*frame*/) { return 0; });
  EXPECT_LT(largest_difference(world.good.features.blocks(), expected), 1e-4);
}

// So that memory stays bounded: a keyframe that has moved meanwhile is seen.
TYPED_TEST(OrbSlamAdapter, covariances_of_points_that_are_not_seen_for_long_are_forgotten) {
  OrbWorld<TypeParam> one(this->random, 10, 5, 10, Sensor::stereo), other(this->random, 10, 5, 10, Sensor::stereo);
  for (const auto& point : other.points) point->mnId += 10;
  typename TypeParam::Adapter good(5);
  good.features.rejects_outliers = false;
  good.use_covariances = true;
  for (int frame = 0; frame <= 450; ++frame) {
    OrbWorld<TypeParam>& world = frame < 5 || frame > 440 ? one : other;
    if (frame == 300) TypeParam::set_pose(one.keyframes[0], one.near(this->random, 3, 0.1));
    good.optimize(world.frame, [](typename TypeParam::Frame* /*frame*/) { return 0; });
    if (frame % 20 == 0 || frame == 450) {
      EXPECT_LT(largest_difference(good.features.blocks(), world.all_seen()), 1e-4) << frame;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
