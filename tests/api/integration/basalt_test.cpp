// SPDX-License-Identifier: MIT
// The adapter of Basalt and the guide's lines for it: landmarks by direction and inverse distance in their host camera,
// and what is entered into the data base.
#include "tests/api/integration/basalt_snippets.hpp"

#include "tests/api/integration/adapter_world.hpp"
#include "tests/support/numbers.hpp"

#include <algorithm>
#include <set>
#include <vector>

namespace maxlogdet::test {
namespace {

using basalt::KeypointId;

Sophus::SE3d random_transform(Random& random, double scale) {
  const sim::Pose pose = random_pose(random);
  return {pose.linear(), scale * pose.translation()};
}

// Landmarks hosted by both cameras of two keyframes, candidate i with the id 2 i; those with an odd id are not in the
// data base. Every third one is seen by both cameras.
class BasaltWorld : public AdapterWorld {
 public:
  BasaltWorld(Random& random, std::size_t n, std::size_t budget, std::size_t capacity) : n_(n) {
    estimator.good_features = Basalt(budget, capacity);
    estimator.calib.T_i_c = {random_transform(random, 0.1), random_transform(random, 0.1)};
    for (basalt::FrameId frame = 1; frame <= 3; ++frame) {
      estimator.frame_states.emplace(frame, basalt::PoseStateWithLin<double>(random_transform(random, 1)));
    }
    estimator.last_state_t_ns = flow->t_ns = 3;
    flow->observations.resize(2);
    for (KeypointId id = 0; id < 2 * n; ++id) {
      flow->observations[0][id] = Eigen::Vector2f::Zero();
      if (id % 3 == 0) flow->observations[1][id] = Eigen::Vector2f::Zero();
      if (id % 2 == 0) add_landmark(random, id);
    }
  }

  TrackerHook& hook() override { return estimator.good_features; }

  // What is not left out: of that observations are entered, by both cameras, and all is counted.
  std::set<std::size_t> run() override {
    estimator.lmdb.observed.clear();
    estimator.connected0 = 0;
    estimator.measure(flow);
    std::set<std::size_t> kept;
    std::vector<KeypointId> entered;
    for (const auto& camera : flow->observations) {
      for (const auto& observation : camera) {
        const KeypointId id = observation.first;
        if (id % 2 == 1 || estimator.good_features.leaves_out(id)) continue;
        entered.push_back(id);
        kept.insert(id / 2);
      }
    }
    EXPECT_EQ(estimator.lmdb.observed, entered);
    EXPECT_EQ(estimator.connected0, n_);
    EXPECT_EQ(estimator.good_features.left_out_count(), n_ - kept.size());
    return kept;
  }

  std::vector<Matrix6> informations() const override {
    std::vector<Matrix6> all;
    for (const Eigen::Vector3d& p_c : in_camera_) all.push_back(information_of({p_c, 0, 1, 1, 0.5 / 460}));
    return all;
  }

  void lose_pose() override { estimator.calib.T_i_c[0] = Sophus::SE3d(2 * Eigen::Matrix3d::Identity(), {0, 0, 0}); }
  void make_not_finite(std::size_t i) override {
    change(i, [](Landmark& landmark) { landmark.direction.x() = nan; });
  }
  void put_behind_camera(std::size_t i) override {
    change(i, [](Landmark& landmark) {
      landmark.direction = basalt::StereographicParam<double>::project({0.1, 0, -1, 0});
      landmark.host_kf_id = {3, 0};
    });
  }
  void put_to_infinity(std::size_t i, double x, double y) {
    change(i, [=](Landmark& landmark) {
      landmark.inv_dist = 0;
      landmark.host_kf_id = {3, 0};
      landmark.direction = Eigen::Vector2d(x, y);
    });
  }

  using Landmark = basalt::Keypoint<double>;
  template <class Change>
  void change(std::size_t i, const Change& change) {
    Landmark landmark = estimator.lmdb.getLandmark(2 * i);
    change(landmark);
    estimator.lmdb.addLandmark(2 * i, landmark);
  }

  basalt::SqrtKeypointVioEstimator<double> estimator;
  std::shared_ptr<basalt::OpticalFlowResult> flow = std::make_shared<basalt::OpticalFlowResult>();

 private:
  // Camera to world.
  Sophus::SE3d camera(basalt::FrameId frame, std::size_t index) const {
    return estimator.getPoseStateWithLin(frame).getPose() * estimator.calib.T_i_c[index];
  }

  void add_landmark(Random& random, KeypointId id) {
    in_camera_.push_back(random_point_in_camera(random));
    Landmark landmark;
    landmark.host_kf_id = {id % 4 == 0 ? 1 : 2, id % 8 < 4 ? 0U : 1U};
    const Sophus::SE3d host = camera(landmark.host_kf_id.frame_id, landmark.host_kf_id.cam_id);
    const Eigen::Vector3d p_h = host.inverse() * (camera(3, 0) * in_camera_.back());
    landmark.inv_dist = 1 / p_h.norm();
    landmark.direction = basalt::StereographicParam<double>::project({p_h.x(), p_h.y(), p_h.z(), 0});
    for (basalt::FrameId frame = 0; frame < 3; ++frame) landmark.obs[{frame, 0}] = Eigen::Vector2d::Zero();
    estimator.lmdb.addLandmark(id, landmark);
  }

  std::size_t n_;
  std::vector<Eigen::Vector3d> in_camera_;
};

constexpr AdapterCase of_basalt[] = {{"Basalt", make_world<BasaltWorld>, 1e-5}};
INSTANTIATE_TEST_SUITE_P(Basalt, AnyAdapter, ::testing::ValuesIn(of_basalt), name_of);

TEST(BasaltAdapter, a_landmark_at_infinity_is_a_candidate) {
  Random random;
  SCOPED_TRACE(random.name());
  BasaltWorld world(random, 10, 5, 10);
  world.put_to_infinity(0, 0.1, 0.1);
  world.run();
  const BlockStore& blocks = world.hook().features.blocks();
  ASSERT_TRUE(blocks.is_valid(0));
  // It measures the rotation as a point nearby does, and no translation.
  const Block H = stored_block(blocks, 0);
  EXPECT_LT(H.leftCols<3>().norm(), 1e-3 * H.rightCols<3>().norm());
  EXPECT_LT(H.norm(), 2 * stored_block(blocks, 1).norm());
}

// Of 100 landmarks, half of them at infinity, how many of these are among the 30 selected ones.
std::size_t selected_at_infinity(Random& random, Weighting weighting) {
  BasaltWorld world(random, 100, 30, 100);
  for (std::size_t i = 0; i < 100; i += 2) {
    world.put_to_infinity(i, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
  }
  world.hook().features.block_options.weighting = weighting;
  const std::set<std::size_t> kept = world.run();
  EXPECT_EQ(kept.size(), 30U);
  return static_cast<std::size_t>(std::count_if(kept.begin(), kept.end(), [](std::size_t i) { return i % 2 == 0; }));
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
  BasaltWorld world(random, 150, 100, 150);
  const std::set<std::size_t> before = world.run();
  std::size_t left_out = 0;
  while (before.count(left_out) > 0) ++left_out;
  world.change(left_out, [](BasaltWorld::Landmark& landmark) { landmark.obs.erase(landmark.obs.begin()); });
  const std::set<std::size_t> after = world.run();
  EXPECT_EQ(after.count(left_out), 1U);
  EXPECT_EQ(after.size(), 100U) << "it counts as budget";
}

}  // namespace
}  // namespace maxlogdet::test
