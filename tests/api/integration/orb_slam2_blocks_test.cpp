// SPDX-License-Identifier: MIT
// The adapter of ORB-SLAM2: blocks, and the covariances of map points that it keeps for them.
#include "tests/api/integration/orb_slam2_world.hpp"

#include <vector>

namespace maxlogdet::test {
namespace {

// An optimiser that changes nothing: for a look at the blocks.
int no_optimization(Frame* /*frame*/) { return 0; }

TEST(OrbSlam2Adapter, blocks_are_derivatives_of_the_projection_under_a_left_perturbation) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool stereo : {false, true}) {
    for (const bool with_covariances : {false, true}) {
      World world(random, 100, stereo);
      OrbSlam2 good(20);
      good.use_covariances = with_covariances;
      good.optimize(world.frame, no_optimization);
      ASSERT_EQ(good.features.blocks().size(), 100U);
      std::vector<std::uint32_t> slots, expected;
      for (std::size_t i = 0; i < good.features.size(); ++i) slots.push_back(good.features.id(i));
      for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
        if (world.frame.mvpMapPoints[i] != nullptr) expected.push_back(static_cast<std::uint32_t>(i));
      }
      EXPECT_EQ(slots, expected);
      EXPECT_LT(largest_difference(good.features.blocks(), seen_matches(world.frame, with_covariances)), 1e-4);
    }
  }
}

// Without an edit of MapPoint. Those of a frame are kept: local bundle adjustment moves a point by little, a new
// observation adds much.
TEST(OrbSlam2Adapter, covariances_are_recomputed_when_the_number_of_observations_changes) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 100, true);
  OrbSlam2 good(20);
  good.use_covariances = true;
  const auto difference_from = [&](const std::vector<SeenPoint>& points) {
    good.optimize(world.frame, no_optimization);
    return largest_difference(good.features.blocks(), points);
  };
  const std::vector<SeenPoint> before = seen_matches(world.frame, true);
  EXPECT_LT(difference_from(before), 1e-4);

  world.keyframes[0]->Tcw = to_mat(world.near(random, 3, 0.1));
  EXPECT_LT(difference_from(before), 1e-4) << "kept";
  for (const auto& point : world.points) world.observe(random, *point, *world.keyframes[1], true);
  const std::vector<SeenPoint> after = seen_matches(world.frame, true);
  EXPECT_LT(difference_from(after), 1e-4) << "recomputed";
  EXPECT_GT(difference_from(before), 1e-2) << "the change is too small for this test";

  world.keyframes[2]->mbBad = true;
  for (const auto& point : world.points) --point->nObs;
  EXPECT_LT(difference_from(seen_matches(world.frame, true)), 1e-4) << "a bad keyframe does not count";
}

// ORB-SLAM2 makes map points of the last frame for the next one alone; no keyframe has seen them.
TEST(OrbSlam2Adapter, a_point_without_observations_has_the_map_deviation_of_the_options) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 50, true);
  MapPoint& unseen = *world.points[7];
  unseen.mObservations.clear();
  unseen.nObs = 0;
  OrbSlam2 good(20);
  good.use_covariances = true;
  good.features.block_options.map_sigma = 0.2;
  good.optimize(world.frame, no_optimization);
  std::vector<SeenPoint> expected;
  for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
    if (world.frame.mvpMapPoints[i] == nullptr) continue;
    expected.push_back(seen_match(world.frame, i, true));
    if (world.frame.mvpMapPoints[i] == &unseen) expected.back().covariance = 0.04 * Eigen::Matrix3d::Identity();
  }
  EXPECT_LT(largest_difference(good.features.blocks(), expected), 1e-4);
}

// So that memory stays bounded: a keyframe that has moved meanwhile is seen.
TEST(OrbSlam2Adapter, covariances_of_points_that_are_not_seen_for_long_are_forgotten) {
  Random random;
  SCOPED_TRACE(random.name());
  World one(random, 10, true);
  World other(random, 10, true);
  for (const auto& point : other.points) point->mnId += 10;
  OrbSlam2 good(5);
  good.use_covariances = true;
  for (int frame = 0; frame < 450; ++frame) {
    World& world = frame < 5 || frame > 440 ? one : other;
    if (frame == 300) one.keyframes[0]->Tcw = to_mat(one.near(random, 3, 0.1));
    good.optimize(world.frame, no_optimization);
    if (frame % 20 != 0) continue;
    EXPECT_LT(largest_difference(good.features.blocks(), seen_matches(world.frame, true)), 1e-4) << frame;
  }
  good.optimize(one.frame, no_optimization);
  EXPECT_LT(largest_difference(good.features.blocks(), seen_matches(one.frame, true)), 1e-4);
}

}  // namespace
}  // namespace maxlogdet::test
