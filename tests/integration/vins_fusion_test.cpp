// SPDX-License-Identifier: MIT
// The guide's code for VINS-Fusion, run: body poses, depths in the first frame of a track, places in para_Feature.
#include "tests/integration/vins_fusion_snippets.hpp"

#include "tests/integration/oracle.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <set>

namespace maxlogdet::test {
namespace {

// A full window. Features with an id divisible by 5 are too short, those by 7 are not seen by the newest frame.
struct World {
  World(Random& random, int n) {
    const sim::Pose T_bc = random_pose(random);
    estimator.frame_count = WINDOW_SIZE;
    for (int camera = 0; camera < 2; ++camera) {
      estimator.ric[camera] = T_bc.linear();
      estimator.tic[camera] = 0.1 * T_bc.translation();
    }
    for (int i = 0; i <= WINDOW_SIZE; ++i) {
      const sim::Pose T_wb = random_pose(random);
      estimator.Rs[i] = T_wb.linear();
      estimator.Ps[i] = T_wb.translation();
    }
    for (int id = 0; id < n; ++id) {
      const bool ended = id % 7 == 0;
      FeaturePerId feature;
      feature.feature_id = id;
      feature.start_frame = WINDOW_SIZE - 7 + (id % 5 == 0 ? 5 : random.integer(0, 4));
      const int last = ended ? WINDOW_SIZE - 1 : WINDOW_SIZE;
      for (int frame = feature.start_frame; frame <= last; ++frame) feature.feature_per_frame.emplace_back();
      // In front of the newest frame, perhaps behind the first one of the track: only the former counts.
      const Eigen::Vector3d p_c = in_camera(feature.start_frame, in_world(random_point_in_camera(random)));
      feature.estimated_depth = std::abs(p_c.z());
      feature.solve_flag = 1;
      feature.feature_per_frame[0].point = p_c / feature.estimated_depth;
      estimator.f_manager.feature.push_back(feature);
    }
  }

  // VINS-Fusion's own chain: camera to body by ric, tic; body to world by Rs, Ps.
  Eigen::Vector3d in_camera(int frame, const Eigen::Vector3d& p_w) const {
    const Eigen::Vector3d p_b = estimator.Rs[frame].transpose() * (p_w - estimator.Ps[frame]);
    return estimator.ric[0].transpose() * (p_b - estimator.tic[0]);
  }
  Eigen::Vector3d in_world(const Eigen::Vector3d& p_c) const {
    const Eigen::Vector3d p_b = estimator.ric[0] * p_c + estimator.tic[0];
    return estimator.Rs[WINDOW_SIZE] * p_b + estimator.Ps[WINDOW_SIZE];
  }

  std::vector<int> candidates() const {
    std::vector<int> ids;
    for (const FeaturePerId& feature : estimator.f_manager.feature) {
      if (feature.feature_id % 7 != 0 && feature.feature_per_frame.size() >= 4) ids.push_back(feature.feature_id);
    }
    return ids;
  }
  std::vector<SeenPoint> seen() const {
    std::vector<SeenPoint> points;
    const std::vector<int> ids = candidates();
    for (const FeaturePerId& feature : estimator.f_manager.feature) {
      if (std::count(ids.begin(), ids.end(), feature.feature_id) == 0) continue;
      const Eigen::Vector3d p_c = feature.feature_per_frame[0].point * feature.estimated_depth;
      const int first = feature.start_frame;
      const Eigen::Vector3d p_w =
          estimator.Rs[first] * (estimator.ric[0] * p_c + estimator.tic[0]) + estimator.Ps[first];
      points.push_back({in_camera(WINDOW_SIZE, p_w), 0, 1, 1, 1.5 / 460});
    }
    return points;
  }

  Estimator estimator;
};

TEST(VinsFusionGuide, blocks_are_derivatives_at_the_newest_camera_and_a_body_pose_is_not) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  GoodFeatures good(1000);
  left_out_features(world.estimator, 100, good);
  const std::vector<SeenPoint> seen = world.seen();
  ASSERT_GT(seen.size(), 150U);
  EXPECT_LT(largest_difference(good.blocks, seen), 1e-5);

  const Eigen::Matrix3d R = world.estimator.Rs[WINDOW_SIZE].transpose();
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> body;
  body << R, -R * world.estimator.Ps[WINDOW_SIZE];
  ASSERT_TRUE(good.build({1, 1, 0, 0, 0}, body.data()));
  EXPECT_GT(largest_difference(good.blocks, seen), 0.1);
}

TEST(VinsFusionGuide, left_out_is_what_the_newest_frame_sees_and_was_not_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  GoodFeatures good(1000);
  const std::set<int> left_out = left_out_features(world.estimator, 100, good);
  const std::vector<int> candidates = world.candidates();
  EXPECT_EQ(left_out.size(), candidates.size() - 100);
  for (const int id : left_out) EXPECT_EQ(std::count(candidates.begin(), candidates.end(), id), 1) << id;
}

TEST(VinsFusionGuide, a_depth_that_was_never_optimised_is_not_left_out) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  GoodFeatures good(1000);
  const std::set<int> before = left_out_features(world.estimator, 100, good);
  std::set<int> fresh;
  for (FeaturePerId& feature : world.estimator.f_manager.feature) {
    if (before.count(feature.feature_id) == 0 || fresh.size() == 30) continue;
    feature.solve_flag = 0;
    fresh.insert(feature.feature_id);
  }
  ASSERT_EQ(fresh.size(), 30U);
  const std::set<int> after = left_out_features(world.estimator, 100, good);
  EXPECT_EQ(after.size(), before.size()) << "they count as budget";
  for (const int id : fresh) EXPECT_EQ(after.count(id), 0U) << id;
}

TEST(VinsFusionGuide, what_is_left_out_is_not_removed_for_its_reprojection_error) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  world.estimator.optimization();
  std::set<int> removed;
  world.estimator.outliersRejection(removed);
  ASSERT_FALSE(world.estimator.left_out.empty());
  EXPECT_EQ(removed.size(), world.estimator.added.size());
  for (const int id : world.estimator.left_out) EXPECT_EQ(removed.count(id), 0U) << id;
}

TEST(VinsFusionGuide, features_keep_their_places_in_para_feature) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  GoodFeatures good(1000);
  const std::set<int> left_out = left_out_features(world.estimator, 100, good);
  world.estimator.optimization();
  std::vector<std::pair<int, int>> expected;
  int place = -1;
  for (const FeaturePerId& feature : world.estimator.f_manager.feature) {
    if (feature.feature_per_frame.size() < 4) continue;
    ++place;
    if (left_out.count(feature.feature_id) == 0) expected.emplace_back(feature.feature_id, place);
  }
  EXPECT_EQ(world.estimator.added, expected);
}

TEST(VinsFusionGuide, nothing_is_left_out_when_there_is_no_selection) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  GoodFeatures small(50);
  EXPECT_TRUE(left_out_features(world.estimator, 100, small).empty()) << "no room";
  GoodFeatures good(1000);
  EXPECT_TRUE(left_out_features(world.estimator, 400, good).empty()) << "no more than the budget";
  world.estimator.Rs[WINDOW_SIZE] *= 2;
  EXPECT_TRUE(left_out_features(world.estimator, 100, good).empty()) << "no rotation";
}

}  // namespace
}  // namespace maxlogdet::test
