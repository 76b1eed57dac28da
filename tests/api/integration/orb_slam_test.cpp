// SPDX-License-Identifier: MIT
// The adapters of ORB-SLAM2 and ORB-SLAM3 and the lines of docs/trackers.md for them: flags of the matches that the
// optimiser was not given, weights of edges, and the covariances of map points that the adapters keep.
#include "tests/api/integration/orb_slam_world.hpp"
#include "tests/support/allocation_counter.hpp"

#include <stdexcept>
#include <string>
#include <type_traits>

namespace maxlogdet::test {
namespace {

using Slam2 = ORB_SLAM2::Tracking;
using Slam3 = ORB_SLAM3::Tracking;

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

// Runs the lines of the page. The guess at which the frame was selected would make all matches outliers.
template <class Slam>
void expect_flags_by_the_new_pose(OrbWorld<Slam>& world) {
  world.run();
  EXPECT_EQ(calls.optimised.size(), 200U);
  const std::set<std::size_t> optimised(calls.optimised.begin(), calls.optimised.end());
  for (std::size_t i = 0; i < world.slots.size(); ++i) {
    EXPECT_EQ(world.is_outlier(i), world.is_wrong(i) && optimised.count(world.slots[i]) == 0) << i;
  }
}

TEST(OrbSlam2Adapter, tracking_counts_all_inliers_not_only_the_selected) {
  TracedRandom random;
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo}) {
    OrbWorld<Slam2> world(random, 400, 200, 400, sensor);
    expect_flags_by_the_new_pose(world);
    int found = 0;
    for (const auto& point : world.points) found += point->mnFound - 1;
    EXPECT_EQ(found, world.tracking.mnMatchesInliers);
    EXPECT_GT(found, 300);
  }
}

TEST(OrbSlam3Adapter, matches_come_back_with_flags_by_the_frames_own_cameras_at_the_new_pose) {
  TracedRandom random;
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::fisheye, Sensor::rig}) {
    for (const bool is_inertial : {false, true}) {
      SCOPED_TRACE(static_cast<int>(sensor));
      OrbWorld<Slam3> world(random, 300, 200, 300, sensor);
      world.tracking.is_inertial = is_inertial;
      expect_flags_by_the_new_pose(world);
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
  EXPECT_EQ(world.good.align(world.frame), 240);
  EXPECT_STREQ(world.good.cost().status, "aligned");
  expect_true_pose(world, world.frame);
  for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(world.is_outlier(i), world.is_wrong(i)) << i;
  typename OrbWorld<TypeParam>::Adapter small(100, 200);
  EXPECT_EQ(small.align(world.frame), 160) << "of the first 200";
  small.features.block_options.min_depth = -1;
  EXPECT_EQ(small.align(world.frame), 0);
  EXPECT_STREQ(small.cost().status, "invalid_block_options");
  world.lose_pose();
  EXPECT_EQ(world.good.align(world.frame), 0);
  EXPECT_STREQ(world.good.cost().status, "invalid_pose");
  for (std::size_t i = 0; i < 300; ++i) EXPECT_TRUE(world.is_outlier(i)) << i;
}

TYPED_TEST(OrbSlamAdapter, the_optimiser_starts_at_the_aligned_pose_with_inliers_alone) {
  OrbWorld<TypeParam> world(this->random, 300, 100, 300);
  world.good.features.rejects_outliers = true;
  const auto expect_aligned = [&](const typename OrbWorld<TypeParam>::Frame* frame) {
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
  const auto fail = [&](typename OrbWorld<TypeParam>::Frame* frame) -> int {
    EXPECT_NE(frame->mvpMapPoints, before);
    throw std::runtime_error("no convergence");
  };
  EXPECT_THROW(world.good.optimize(world.frame, fail), std::runtime_error);
  EXPECT_EQ(world.frame.mvpMapPoints, before);
}

// For tests of what is selected, at the pose of the frame.
template <class Frame>
int no_optimization(Frame* /*frame*/) {
  return 0;
}

TYPED_TEST(OrbSlamAdapter, nothing_but_the_trackers_map_points_allocates_in_a_frame) {
  if (allocations() < 0) GTEST_SKIP() << "allocations cannot be counted here";
  OrbWorld<TypeParam> world(this->random, 400, 100, 400);
  const long copies = allocations_in([&] {
    for (std::size_t i = 0; i < 400; ++i) world.point(i).GetWorldPos();
  });
  const auto optimize = [&] { world.good.optimize(world.frame, no_optimization<typename OrbWorld<TypeParam>::Frame>); };
  EXPECT_EQ(allocations_in(optimize), copies);
}

// Those of the selected matches, whose slots are not their numbers; without covariances what the octave says.
TEST(OrbSlam2Adapter, edges_weigh_what_the_blocks_do) {
  TracedRandom random;
  OrbWorld<Slam2> world(random, 300, 200, 300, Sensor::stereo);
  for (const bool use_covariances : {false, true}) {
    const std::vector<SeenPoint> seen = use_covariances ? world.seen_with_covariances() : world.seen();
    ORB_SLAM2::weighted::Tracking tracking;
    tracking.mCurrentFrame = world.frame;
    tracking.mGoodFeatures.use_covariances = use_covariances;
    tracking.mGoodFeatures.features.is_weighted = true;
    tracking.mGoodFeatures.features.rejects_outliers = false;
    tracking.TrackLocalMap();
    auto& edges = ORB_SLAM2::weighted::Optimizer::edges();
    EXPECT_GT(edges.size(), 10U);
    for (std::size_t i = 0; i < 300; ++i) {
      const auto edge = edges.find(world.slots[i]);
      if (edge == edges.end()) continue;
      EXPECT_LT(relative_difference(edge->second.information, seen[i].weight()), 1e-4) << i;
    }
    double untouched[9] = {-7};
    EXPECT_FALSE(tracking.mGoodFeatures.information(3, untouched)) << "an empty slot";
    EXPECT_FALSE(tracking.mGoodFeatures.information(world.frame.mvpMapPoints.size(), untouched));
    EXPECT_EQ(untouched[0], -7);
  }
}

// By how much the blocks of a frame differ from what the points tell.
template <class Slam, class Adapter>
double difference_from(const std::vector<SeenPoint>& points, OrbWorld<Slam>& world, Adapter& good) {
  good.use_covariances = true;
  good.optimize(world.frame, no_optimization<typename OrbWorld<Slam>::Frame>);
  return largest_difference(good.features.blocks(), points);
}

// Without an edit of MapPoint. Those of a frame are kept: local bundle adjustment moves a point by little, a new
// observation adds much.
TYPED_TEST(OrbSlamAdapter, covariances_are_recomputed_when_the_number_of_observations_changes) {
  OrbWorld<TypeParam> world(this->random, 100, 20, 100, Sensor::stereo);
  const std::vector<SeenPoint> before = world.seen_with_covariances();
  EXPECT_LT(difference_from(before, world, world.good), 1e-4);

  set(world.keyframes[0].mTcw, world.near(this->random, 3, 0.1).matrix());
  EXPECT_LT(difference_from(before, world, world.good), 1e-4) << "kept";
  for (const auto& point : world.points) world.observe(this->random, *point, world.keyframes[1], true);
  EXPECT_LT(difference_from(world.seen_with_covariances(), world, world.good), 1e-4) << "recomputed";
  EXPECT_GT(difference_from(before, world, world.good), 1e-2) << "the change is too small for this test";

  world.keyframes[0].mbBad = true;
  for (const auto& point : world.points) --point->nObs;
  EXPECT_LT(difference_from(world.seen_with_covariances(), world, world.good), 1e-4) << "a bad keyframe does not count";

  for (std::size_t i = 0; i < 100; ++i) {  // by more than half a standard deviation, as when a map is scaled
    set(world.point(i).mWorldPos, world.T_cw.inverse() * (5 * (world.T_cw * world.position_of(i))));
  }
  EXPECT_LT(difference_from(world.seen_with_covariances(), world, world.good), 1e-4) << "recomputed: the map has moved";
}

TEST(OrbSlam3Adapter, keyframes_of_rigs_and_what_right_cameras_alone_see_do_not_count) {
  TracedRandom random;
  OrbWorld<Slam3> world(random, 60, 20, 60);
  const std::vector<SeenPoint> expected = world.seen_with_covariances();
  ORB_SLAM3::KeyFrame of_rig = world.keyframes[0], of_right = world.keyframes[0];
  of_rig.mpCamera2 = &world.cameras.fisheye;
  for (const auto& point : world.points) {
    point->mObservations[&of_rig] = std::make_tuple(0, -1);
    point->mObservations[&of_right] = std::make_tuple(-1, 3);
  }
  EXPECT_LT(difference_from(expected, world, world.good), 1e-4);
}

// The trackers make map points of the last frame for the next one alone; no keyframe has seen them.
TYPED_TEST(OrbSlamAdapter, a_point_without_observations_has_the_map_deviation_of_the_options) {
  OrbWorld<TypeParam> world(this->random, 50, 20, 50, Sensor::stereo);
  std::vector<SeenPoint> expected = world.seen_with_covariances();
  expected[7].covariance = 0.04 * Eigen::Matrix3d::Identity();
  world.point(7).mObservations.clear();
  world.point(7).nObs = 0;
  world.good.features.block_options.map_sigma = 0.2;
  EXPECT_LT(difference_from(expected, world, world.good), 1e-4);
}

// So that memory stays bounded: a keyframe that has moved meanwhile is seen.
TYPED_TEST(OrbSlamAdapter, covariances_of_points_that_are_not_seen_for_long_are_forgotten) {
  OrbWorld<TypeParam> one(this->random, 10, 5, 10, Sensor::stereo), other(this->random, 10, 5, 10, Sensor::stereo);
  for (const auto& point : other.points) point->mnId += 10;
  typename OrbWorld<TypeParam>::Adapter good(5);
  good.features.rejects_outliers = false;
  for (int frame = 0; frame <= 450; ++frame) {
    OrbWorld<TypeParam>& world = frame < 5 || frame > 440 ? one : other;
    if (frame == 300) set(one.keyframes[0].mTcw, one.near(this->random, 3, 0.1).matrix());
    const double difference = difference_from(world.seen_with_covariances(), world, good);
    if (frame % 20 == 0 || frame == 450) {
      EXPECT_LT(difference, 1e-4) << frame;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
