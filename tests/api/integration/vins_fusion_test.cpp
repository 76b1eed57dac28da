// SPDX-License-Identifier: MIT
// The adapter of VINS-Fusion and the guide's lines for it: body poses, depths in the first frame of a track, places in
// para_Feature.
#include "tests/api/integration/vins_fusion_snippets.hpp"

#include "tests/api/integration/oracle.hpp"
#include "tests/support/recording.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <string>

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
      FeaturePerId feature(id, WINDOW_SIZE - 7 + (id % 5 == 0 ? 5 : random.integer(0, 4)));
      const int last = ended ? WINDOW_SIZE - 1 : WINDOW_SIZE;
      for (int frame = feature.start_frame; frame <= last; ++frame) feature.feature_per_frame.emplace_back();
      // In front of the newest frame, perhaps behind the first one of the track: only the former counts.
      const Eigen::Vector3d p_c = in_camera(feature.start_frame, in_world(random_point_in_camera(random)));
      feature.estimated_depth = std::abs(p_c.z());
      feature.solve_flag = 1;
      feature.feature_per_frame[0].point = p_c / feature.estimated_depth;
      feature.feature_per_frame.back().point = Eigen::Vector3d(id, 0.5 * id, 1);
      estimator.f_manager.feature.push_front(feature);  // in no order that anything may rely on
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

  // What is left out, of all features.
  std::set<int> left_out(const VinsFusion& good) const {
    std::set<int> ids;
    for (const FeaturePerId& feature : estimator.f_manager.feature) {
      if (good.leaves_out(static_cast<std::uint64_t>(feature.feature_id))) ids.insert(feature.feature_id);
    }
    EXPECT_EQ(ids.size(), good.left_out_count());
    return ids;
  }

  Estimator estimator;
};

TEST(VinsFusionAdapter, blocks_are_derivatives_at_the_newest_camera) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  VinsFusion good(100);
  good.ask(world.estimator);
  const std::vector<SeenPoint> seen = world.seen();
  ASSERT_GT(seen.size(), 150U);
  ASSERT_EQ(good.features.blocks().size(), seen.size());
  EXPECT_LT(largest_difference(good.features.blocks(), seen), 1e-5);
}

TEST(VinsFusionAdapter, left_out_is_what_the_newest_frame_sees_and_was_not_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  VinsFusion good(100);
  good.ask(world.estimator);
  const std::vector<int> candidates = world.candidates();
  const auto selected = select_indices(good.features.blocks(), good.options);
  std::set<int> expected(candidates.begin(), candidates.end());
  for (const std::uint32_t i : selected) expected.erase(candidates[i]);
  EXPECT_EQ(world.left_out(good), expected);
  EXPECT_EQ(expected.size(), candidates.size() - 100);
  EXPECT_STREQ(good.cost().status, "ok");
  EXPECT_EQ(good.cost().candidates, candidates.size());
  EXPECT_EQ(good.cost().selected, 100U);
}

TEST(VinsFusionAdapter, a_recorded_frame_has_the_candidates_as_the_newest_image_measures_them) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  const TemporaryFolder folder;
  VinsFusion good(100);
  ASSERT_TRUE(good.record(folder.path().c_str()));
  good.ask(world.estimator);
  const RecordedFrame recorded(folder / "frame_000000.csv");
  EXPECT_EQ(recorded.numbers("fx,fy,cx,cy,bf"), (std::vector<double>{1, 1, 0, 0, 0}));
  const std::vector<int> candidates = world.candidates();
  const std::set<int> left_out = world.left_out(good);
  ASSERT_EQ(recorded.rows.size(), candidates.size());
  for (std::size_t row = 0; row < candidates.size(); ++row) {
    const int id = candidates[row];
    EXPECT_EQ(recorded.at(row, "mp_id"), id);
    EXPECT_EQ(recorded.at(row, "u"), id);
    EXPECT_EQ(recorded.at(row, "v"), 0.5 * id);
    EXPECT_NEAR(std::sqrt(recorded.at(row, "inv_sigma2")), 460 / 1.5, 1e-9);
    EXPECT_EQ(recorded.at(row, "selected"), left_out.count(id) > 0 ? 0 : 1);
  }
}

TEST(VinsFusionAdapter, a_depth_that_was_never_optimised_is_not_left_out) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  VinsFusion good(100);
  good.ask(world.estimator);
  const std::set<int> before = world.left_out(good);
  std::set<int> fresh;
  for (FeaturePerId& feature : world.estimator.f_manager.feature) {
    if (before.count(feature.feature_id) == 0 || fresh.size() == 30) continue;
    feature.solve_flag = 0;
    fresh.insert(feature.feature_id);
  }
  ASSERT_EQ(fresh.size(), 30U);
  good.ask(world.estimator);
  const std::set<int> after = world.left_out(good);
  EXPECT_EQ(after.size(), before.size()) << "they count as budget";
  for (const int id : fresh) EXPECT_EQ(after.count(id), 0U) << id;
}

TEST(VinsFusionAdapter, features_without_a_depth_and_behind_the_camera_stay_in) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  const std::vector<int> candidates = world.candidates();
  std::size_t without_depth = 0;
  std::set<int> odd;
  for (FeaturePerId& feature : world.estimator.f_manager.feature) {
    if (feature.feature_id % 11 == 3) feature.estimated_depth = -1;
    if (feature.feature_id % 11 == 4) {
      feature.feature_per_frame[0].point = world.in_camera(feature.start_frame, world.in_world({0.1, 0, -5}));
      feature.estimated_depth = 1;
    }
    if (feature.feature_id % 11 == 3 || feature.feature_id % 11 == 4) odd.insert(feature.feature_id);
    if (feature.estimated_depth < 0) {
      without_depth += static_cast<std::size_t>(std::count(candidates.begin(), candidates.end(), feature.feature_id));
    }
  }
  VinsFusion good(50);
  good.ask(world.estimator);
  const std::set<int> left_out = world.left_out(good);
  EXPECT_GT(left_out.size(), 50U);
  EXPECT_EQ(good.cost().candidates, candidates.size() - without_depth);
  for (const int id : odd) EXPECT_EQ(left_out.count(id), 0U) << id;
}

TEST(VinsFusionAdapter, what_is_left_out_is_not_removed_for_its_reprojection_error) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  world.estimator.optimization();
  std::set<int> removed;
  world.estimator.outliersRejection(removed);
  const std::set<int> left_out = world.left_out(world.estimator.good_features);
  ASSERT_FALSE(left_out.empty());
  EXPECT_EQ(removed.size(), world.estimator.added.size());
  for (const int id : left_out) EXPECT_EQ(removed.count(id), 0U) << id;
}

TEST(VinsFusionAdapter, features_keep_their_places_in_para_feature) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  VinsFusion good(100);
  good.ask(world.estimator);
  const std::set<int> left_out = world.left_out(good);
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

TEST(VinsFusionAdapter, of_few_features_and_after_an_error_none_is_left_out) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  const auto expect_all = [&](VinsFusion good, const std::string& why) {
    good.ask(world.estimator);
    EXPECT_TRUE(world.left_out(good).empty()) << why;
    EXPECT_EQ(good.cost().status, why);
  };
  expect_all(VinsFusion(400), "all_selected");
  VinsFusion good(100);
  good.ask(world.estimator);
  EXPECT_FALSE(world.left_out(good).empty());
  world.estimator.Rs[WINDOW_SIZE] *= 2;  // no rotation
  expect_all(std::move(good), "invalid_pose");
}

TEST(VinsFusionAdapter, at_a_deadline_all_but_the_budget_are_left_out_and_beyond_the_capacity_none) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 300);
  VinsFusion good(100);
  good.options.time_limit = 1e-9;
  good.ask(world.estimator);
  EXPECT_EQ(world.left_out(good).size(), world.candidates().size() - 100);
  EXPECT_STREQ(good.cost().status, "deadline_reached");
  good = VinsFusion(40, 50);
  good.ask(world.estimator);
  EXPECT_EQ(world.left_out(good).size(), 10U);
  EXPECT_STREQ(good.cost().status, "capacity_exceeded");
}

TEST(VinsFusionAdapter, a_feature_that_is_not_finite_stays_in) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  VinsFusion good(40);
  good.ask(world.estimator);
  const int id = *world.left_out(good).begin();
  for (FeaturePerId& feature : world.estimator.f_manager.feature) {
    if (feature.feature_id == id) feature.feature_per_frame[0].point.x() = std::numeric_limits<double>::quiet_NaN();
  }
  good.ask(world.estimator);
  EXPECT_EQ(world.left_out(good).count(id), 0U);
  EXPECT_EQ(good.cost().selected, 41U);
}

}  // namespace
}  // namespace maxlogdet::test
