// SPDX-License-Identifier: MIT
// The adapter of Basalt and the guide's lines for it: landmarks by direction and inverse distance in their host camera,
// and what is entered into the data base.
#include "tests/api/integration/basalt_snippets.hpp"

#include "tests/api/integration/oracle.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <string>

namespace maxlogdet::test {
namespace {

using basalt::KeypointId;

Sophus::SE3d random_transform(Random& random, double scale) {
  const sim::Pose pose = random_pose(random);
  return {pose.linear(), scale * pose.translation()};
}

// Landmarks hosted by both cameras of two keyframes; those with an odd id are not in the data base.
struct World {
  World(Random& random, KeypointId n) {
    estimator.calib.T_i_c = {random_transform(random, 0.1), random_transform(random, 0.1)};
    estimator.frame_states.emplace(1, basalt::PoseStateWithLin<double>(random_transform(random, 1)));
    estimator.frame_states.emplace(2, basalt::PoseStateWithLin<double>(random_transform(random, 1)));
    estimator.frame_states.emplace(3, basalt::PoseStateWithLin<double>(random_transform(random, 1)));
    estimator.last_state_t_ns = 3;
    flow->t_ns = 3;
    flow->observations.resize(2);
    for (KeypointId id = 0; id < n; ++id) {
      flow->observations[0][id] = Eigen::Vector2f::Zero();
      if (id % 3 == 0) flow->observations[1][id] = Eigen::Vector2f::Zero();
      if (id % 2 == 1) continue;
      const Eigen::Vector3d p_c = random_point_in_camera(random);
      const Eigen::Vector3d p_w = camera(3, 0) * p_c;
      basalt::Keypoint<double> landmark;
      landmark.host_kf_id = {id % 4 == 0 ? 1 : 2, id % 8 < 4 ? 0U : 1U};
      const Eigen::Vector3d p_h = camera(landmark.host_kf_id.frame_id, landmark.host_kf_id.cam_id).inverse() * p_w;
      landmark.inv_dist = 1 / p_h.norm();
      landmark.direction = basalt::StereographicParam<double>::project({p_h.x(), p_h.y(), p_h.z(), 0});
      for (basalt::FrameId frame = 0; frame < 3; ++frame) landmark.obs[{frame, 0}] = Eigen::Vector2d::Zero();
      estimator.lmdb.addLandmark(id, landmark);
      seen.push_back({p_c, 0, 1, 1, 0.5 / 460});
    }
  }

  // Camera to world.
  Sophus::SE3d camera(basalt::FrameId frame, std::size_t index) const {
    return estimator.getPoseStateWithLin(frame).getPose() * estimator.calib.T_i_c[index];
  }

  std::set<KeypointId> left_out(Basalt& good) const {
    const auto pose_of = [this](basalt::FrameId frame) { return estimator.getPoseStateWithLin(frame).getPose(); };
    good.ask(estimator.lmdb, flow->observations[0], estimator.calib, pose_of(3), pose_of);
    std::set<KeypointId> ids;
    for (const auto& observation : flow->observations[0]) {
      if (good.leaves_out(observation.first)) ids.insert(observation.first);
    }
    EXPECT_EQ(ids.size(), good.left_out_count());
    return ids;
  }

  basalt::SqrtKeypointVioEstimator<double> estimator;
  std::shared_ptr<basalt::OpticalFlowResult> flow = std::make_shared<basalt::OpticalFlowResult>();
  std::vector<SeenPoint> seen;
};

TEST(BasaltAdapter, blocks_are_derivatives_at_the_newest_camera) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  Basalt good(100);
  world.left_out(good);
  EXPECT_EQ(world.seen.size(), 150U);
  ASSERT_EQ(good.features.blocks().size(), 150U);
  EXPECT_LT(largest_difference(good.features.blocks(), world.seen), 1e-5);
}

TEST(BasaltAdapter, left_out_is_what_was_not_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  Basalt good(100);
  const std::set<KeypointId> left_out = world.left_out(good);
  std::set<KeypointId> expected;
  for (KeypointId id = 0; id < 300; id += 2) expected.insert(id);
  for (const std::uint32_t i : select_indices(good.features.blocks(), good.options)) expected.erase(2 * i);
  EXPECT_EQ(left_out, expected);
  EXPECT_EQ(left_out.size(), 50U);
  EXPECT_STREQ(good.cost().status, "ok");
  EXPECT_EQ(good.cost().candidates, 150U);
  EXPECT_EQ(good.cost().selected, 100U);
}

TEST(BasaltAdapter, a_landmark_at_infinity_is_a_candidate) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 20);
  basalt::Keypoint<double> landmark = world.estimator.lmdb.getLandmark(0);
  landmark.inv_dist = 0;
  landmark.host_kf_id = {3, 0};
  landmark.direction = Eigen::Vector2d(0.1, 0.1);
  world.estimator.lmdb.addLandmark(0, landmark);
  Basalt good(5);
  world.left_out(good);
  ASSERT_TRUE(good.features.blocks().is_valid(0));
  // It measures the rotation as a point nearby does, and no translation.
  const Block H = stored_block(good.features.blocks(), 0);
  EXPECT_LT(H.leftCols<3>().norm(), 1e-3 * H.rightCols<3>().norm());
  EXPECT_LT(H.norm(), 2 * stored_block(good.features.blocks(), 1).norm());
}

// Of 100 landmarks, half of them at infinity, how many of these are among the 30 selected ones.
std::size_t selected_at_infinity(Random& random, Weighting weighting) {
  World world(random, 200);
  std::vector<KeypointId> infinite;
  for (KeypointId id = 0; id < 200; id += 4) {
    basalt::Keypoint<double> landmark = world.estimator.lmdb.getLandmark(id);
    landmark.inv_dist = 0;
    landmark.host_kf_id = {3, 0};
    landmark.direction = Eigen::Vector2d(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
    world.estimator.lmdb.addLandmark(id, landmark);
    infinite.push_back(id);
  }
  Basalt good(30);
  good.features.block_options.weighting = weighting;
  const std::set<KeypointId> left_out = world.left_out(good);
  EXPECT_EQ(left_out.size(), 70U);
  std::size_t selected = 0;
  for (const KeypointId id : infinite) selected += 1 - left_out.count(id);
  return selected;
}

TEST(BasaltAdapter, landmarks_at_infinity_do_not_displace_those_that_measure_translation) {
  Random random;
  SCOPED_TRACE(random.name());
  std::size_t by_measurement = 0, by_map_bias = 0;
  for (int world = 0; world < 20; ++world) {
    by_measurement += selected_at_infinity(random, Weighting::measurement);
    by_map_bias += selected_at_infinity(random, Weighting::map_bias);
  }
  // Drawn at random there would be 15 of 30 in each world.
  EXPECT_LT(by_measurement, 20U * 15);
  EXPECT_GT(by_map_bias, 20U * 15);
}

TEST(BasaltAdapter, a_landmark_with_two_observations_is_not_left_out) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  Basalt good(100);
  const std::set<KeypointId> before = world.left_out(good);
  ASSERT_EQ(before.size(), 50U);
  const KeypointId id = *before.begin();
  basalt::Keypoint<double> landmark = world.estimator.lmdb.getLandmark(id);
  landmark.obs.erase(landmark.obs.begin());
  world.estimator.lmdb.addLandmark(id, landmark);
  const std::set<KeypointId> after = world.left_out(good);
  EXPECT_EQ(after.count(id), 0U);
  EXPECT_EQ(after.size(), 50U) << "it counts as budget";
}

TEST(BasaltAdapter, observations_of_what_is_left_out_are_not_entered_but_counted) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  Basalt good(100);
  const std::set<KeypointId> left_out = world.left_out(good);
  EXPECT_EQ(left_out.size(), 50U);
  world.estimator.measure(world.flow);
  std::vector<KeypointId> expected;
  for (const auto& camera : world.flow->observations) {
    for (const auto& observation : camera) {
      if (observation.first % 2 == 0 && left_out.count(observation.first) == 0) expected.push_back(observation.first);
    }
  }
  EXPECT_EQ(world.estimator.lmdb.observed, expected);
  EXPECT_EQ(world.estimator.connected0, 150U);
}

TEST(BasaltAdapter, of_few_landmarks_and_after_an_error_none_is_left_out) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  const auto expect_all = [&](Basalt good, const std::string& why) {
    EXPECT_TRUE(world.left_out(good).empty()) << why;
    EXPECT_EQ(good.cost().status, why);
  };
  expect_all(Basalt(150), "all_selected");
  Basalt good(100);
  EXPECT_FALSE(world.left_out(good).empty());
  world.estimator.calib.T_i_c[0] = Sophus::SE3d(2 * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
  expect_all(std::move(good), "invalid_pose");
}

TEST(BasaltAdapter, at_a_deadline_all_but_the_budget_are_left_out_and_beyond_the_capacity_none) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  Basalt good(100);
  good.options.time_limit = 1e-9;
  EXPECT_EQ(world.left_out(good).size(), 50U);
  EXPECT_STREQ(good.cost().status, "deadline_reached");
  good = Basalt(40, 50);
  EXPECT_EQ(world.left_out(good).size(), 10U);
  EXPECT_STREQ(good.cost().status, "capacity_exceeded");
}

TEST(BasaltAdapter, landmarks_that_are_not_finite_or_behind_the_camera_stay_in) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  Basalt good(100);
  const std::set<KeypointId> before = world.left_out(good);
  basalt::Keypoint<double> landmark = world.estimator.lmdb.getLandmark(*before.begin());
  landmark.direction.x() = std::numeric_limits<double>::quiet_NaN();
  world.estimator.lmdb.addLandmark(*before.begin(), landmark);
  landmark.direction = basalt::StereographicParam<double>::project({0.1, 0, -1, 0});
  landmark.host_kf_id = {3, 0};
  world.estimator.lmdb.addLandmark(*before.rbegin(), landmark);
  const std::set<KeypointId> after = world.left_out(good);
  EXPECT_EQ(after.count(*before.begin()) + after.count(*before.rbegin()), 0U);
  EXPECT_EQ(good.cost().selected, 102U);
}

}  // namespace
}  // namespace maxlogdet::test
