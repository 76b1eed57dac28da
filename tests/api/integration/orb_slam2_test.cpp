// SPDX-License-Identifier: MIT
// The adapter of ORB-SLAM2 and the guide's lines for it: the optimisation with the selected matches alone.
#include "sim/outlier_rejection.hpp"
#include "tests/api/integration/orb_slam2_world.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/recording.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// The slots that a selector of its own selects from the oracle's information.
std::set<std::size_t> slots_selected_from(const World& world, const Options& options) {
  BlockStore blocks(world.frame.mvpMapPoints.size());
  std::vector<std::size_t> slots;
  for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
    if (world.frame.mvpMapPoints[i] == nullptr) continue;
    const SeenPoint seen = seen_match(world.frame, i, false);
    Eigen::MatrixXd H = Derivatives(seen).H_x.topRows(seen.bf > 0 ? 3 : 2) / seen.sigma;
    push_back(blocks, H);
    slots.push_back(i);
  }
  std::set<std::size_t> selected;
  for (const std::uint32_t i : select_indices(blocks, options)) selected.insert(slots[i]);
  return selected;
}

TEST(OrbSlam2Adapter, only_selected_matches_enter_the_optimiser_and_none_stays_null) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool stereo : {false, true}) {
    World world(random, 400, stereo);
    const std::vector<MapPoint*> before = world.frame.mvpMapPoints;
    OrbSlam2 good(100);
    const std::set<std::size_t> expected = slots_selected_from(world, good.options);
    const int inliers = good.optimize(world.frame, ORB_SLAM2::Optimizer::PoseOptimization);
    EXPECT_EQ(calls.optimiser_calls, 1);
    EXPECT_EQ(std::set<std::size_t>(calls.optimised.begin(), calls.optimised.end()), expected);
    EXPECT_EQ(expected.size(), 100U);
    EXPECT_EQ(world.frame.mvpMapPoints, before);
    EXPECT_GT(inliers, 300) << "of 350 true ones, not only of the selected";
    for (std::size_t i = 0; i < good.features.size(); ++i) {
      EXPECT_EQ(good.features.is_selected(i), expected.count(good.features.id(i)) > 0) << i;
    }
  }
}

// Sigma = Sigma_z + J Sigma_p J^T of the selected matches, whose slots are not their numbers; without covariances what
// the octave says.
TEST(OrbSlam2Adapter, edges_weigh_what_the_blocks_do) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300, true);
  for (const bool use_covariances : {false, true}) {
    ORB_SLAM2::weighted::Tracking tracking;
    tracking.mCurrentFrame = world.frame;
    tracking.mGoodFeatures.use_covariances = use_covariances;
    tracking.mGoodFeatures.features.is_weighted = true;
    tracking.TrackLocalMap();
    EXPECT_GT(calls.weights.size(), 10U);
    for (const auto& weight : calls.weights) {
      const SeenPoint seen = seen_match(world.frame, weight.first, use_covariances);
      const Derivatives derivatives(seen);
      const Eigen::MatrixXd map = product(product(derivatives.H_p, seen.covariance), derivatives.H_p.transpose());
      const Eigen::MatrixXd Sigma = map + seen.sigma * seen.sigma * Eigen::Matrix3d::Identity();
      EXPECT_LT(relative_difference(weight.second, inverse(Sigma)), 1e-4) << weight.first;
    }
    double untouched[9] = {-7};
    const auto empty = std::find(world.frame.mvpMapPoints.begin(), world.frame.mvpMapPoints.end(), nullptr);
    const auto slot = static_cast<std::size_t>(empty - world.frame.mvpMapPoints.begin());
    EXPECT_FALSE(tracking.mGoodFeatures.information(slot, untouched));
    EXPECT_FALSE(tracking.mGoodFeatures.information(world.frame.mvpMapPoints.size(), untouched));
    EXPECT_EQ(untouched[0], -7);
  }
}

TEST(OrbSlam2Adapter, outlier_flags_follow_chi2_under_the_new_pose_and_inliers_are_counted) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool stereo : {false, true}) {
    World world(random, 400, stereo);
    const Frame guess = world.frame;
    // Flags left over from before, right or wrong, must not matter.
    for (auto&& flag : world.frame.mvbOutlier) flag = random.chance(0.5);
    OrbSlam2 good(100);
    const int inliers = good.optimize(world.frame, ORB_SLAM2::Optimizer::PoseOptimization);

    int counted = 0, differs_from_guess = 0;
    for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
      if (world.frame.mvpMapPoints[i] == nullptr) continue;
      const sim::Match match = match_of(world.frame, i);
      const double threshold = match.is_stereo() ? chi2_of_three : chi2_of_two;
      const double chi2 = sim::chi2(camera_in_double(world.frame), pose_in_double(world.frame), match, true);
      if (!world.frame.mvbOutlier[i]) ++counted;
      if (std::abs(chi2 - threshold) < 0.01) continue;  // the optimiser judged with a pose of double
      EXPECT_EQ(world.frame.mvbOutlier[i], chi2 > threshold) << "match " << i << ", chi2 " << chi2;
      const double at_guess = sim::chi2(camera_in_double(guess), pose_in_double(guess), match, true);
      if ((at_guess > threshold) != (chi2 > threshold)) ++differs_from_guess;
    }
    EXPECT_EQ(inliers, counted);
    EXPECT_GT(differs_from_guess, 20) << "the guess is too good for this test";
    EXPECT_LT((pose_in_double(world.frame) * world.T_cw.inverse()).translation().norm(), 0.03);
  }
}

TEST(OrbSlam2Adapter, a_point_behind_the_camera_is_an_outlier) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 200, false);
  world.add_slot(world.new_point(random, {0, 0, -5}), cv::KeyPoint(), -1);
  OrbSlam2 good(100);
  good.optimize(world.frame, ORB_SLAM2::Optimizer::PoseOptimization);
  EXPECT_EQ(calls.optimised.size(), 100U);
  EXPECT_TRUE(world.frame.mvbOutlier.back());
  EXPECT_NE(world.frame.mvpMapPoints.back(), nullptr);
}

TEST(OrbSlam2Adapter, tracking_counts_all_inliers_not_only_the_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 400, true);
  ORB_SLAM2::Tracking tracking;
  tracking.mCurrentFrame = world.frame;
  EXPECT_TRUE(tracking.TrackLocalMap());
  EXPECT_EQ(calls.optimised.size(), 200U);
  EXPECT_GT(tracking.mnMatchesInliers, 300);
  int found = 0;
  for (const auto& point : world.points) found += point->mnFound - 1;
  EXPECT_EQ(found, tracking.mnMatchesInliers);
}

// Optimises the world's frame, and returns the slots that entered the optimiser; all matches are in the frame again,
// and the inliers are those without a flag.
std::set<std::size_t> slots_optimised_with(OrbSlam2& good, World& world) {
  calls = Calls();
  const std::vector<MapPoint*> before = world.frame.mvpMapPoints;
  const int inliers = good.optimize(world.frame, ORB_SLAM2::Optimizer::PoseOptimization);
  EXPECT_EQ(calls.optimiser_calls, 1);
  EXPECT_EQ(world.frame.mvpMapPoints, before);
  EXPECT_EQ(good.cost().candidates, world.match_count());
  EXPECT_EQ(good.cost().selected, calls.optimised.size());
  int counted = 0;
  for (std::size_t i = 0; i < before.size(); ++i) counted += before[i] != nullptr && !world.frame.mvbOutlier[i] ? 1 : 0;
  if (!world.frame.mTcw.empty()) {
    EXPECT_EQ(inliers, counted);
  }
  return {calls.optimised.begin(), calls.optimised.end()};
}

TEST(OrbSlam2Adapter, few_matches_and_after_an_error_all_are_optimised_with) {
  Random random;
  SCOPED_TRACE(random.name());
  const auto expect_all = [&](OrbSlam2 good, World world, const std::string& why) {
    SCOPED_TRACE(why);
    EXPECT_EQ(slots_optimised_with(good, world).size(), world.match_count());
    EXPECT_EQ(good.cost().status, why);
  };
  expect_all(OrbSlam2(100), World(random, 90, true), "all_selected");
  expect_all(OrbSlam2(400, 300), World(random, 290, true), "all_selected");
  World world(random, 400, true);
  world.frame.mTcw.at<float>(0, 0) = 5;  // no rotation
  expect_all(OrbSlam2(100), std::move(world), "invalid_pose");
  world = World(random, 400, true);
  world.frame.mTcw = cv::Mat();
  expect_all(OrbSlam2(100), std::move(world), "invalid_pose");
  OrbSlam2 good(100);
  good.features.block_options.min_depth = -1;
  expect_all(std::move(good), World(random, 400, true), "invalid_block_options");
  const double no_prior[36] = {};
  good = OrbSlam2(100);
  good.options.prior = no_prior;
  expect_all(std::move(good), World(random, 400, true), "invalid_prior");
}

TEST(OrbSlam2Adapter, at_a_deadline_a_full_budget_is_optimised_with) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 400, true);
  OrbSlam2 good(100);
  good.options.time_limit = 1e-9;
  EXPECT_EQ(slots_optimised_with(good, world).size(), 100U);
  EXPECT_STREQ(good.cost().status, "deadline_reached");
  EXPECT_GT(std::count(world.frame.mvbOutlier.begin(), world.frame.mvbOutlier.end(), false), 300);
}

TEST(OrbSlam2Adapter, nothing_but_the_trackers_map_points_allocates_in_a_frame) {
  if (allocations() < 0) GTEST_SKIP() << "allocations cannot be counted here";
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 400, true);
  OrbSlam2 good(100);
  const auto keep_the_pose = [](const Frame* /*frame*/) { return 100; };
  const long copies = allocations_in([&] {
    for (MapPoint* const point : world.frame.mvpMapPoints) {
      if (point != nullptr) point->GetWorldPos();
    }
  });
  EXPECT_EQ(allocations_in([&] { good.optimize(world.frame, keep_the_pose); }), copies);
}

TEST(OrbSlam2Adapter, matches_beyond_the_capacity_are_optimised_with) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 400, true);
  OrbSlam2 good(100, 300);
  const std::set<std::size_t> optimised = slots_optimised_with(good, world);
  EXPECT_EQ(optimised.size(), 200U);
  EXPECT_EQ(optimised.count(world.frame.mvpMapPoints.size() - 1), 1U);
  EXPECT_STREQ(good.cost().status, "capacity_exceeded");
}

TEST(OrbSlam2Adapter, a_match_that_is_not_finite_is_an_outlier_that_never_enters_the_optimiser) {
  Random random;
  SCOPED_TRACE(random.name());
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (const bool has_error : {false, true}) {
    for (const std::size_t budget : {100U, 500U}) {
      World world(random, 400, true);
      MapPoint* const nowhere = world.new_point(random, {0, 0, 5});
      nowhere->mWorldPos.at<float>(1) = nan;
      world.add_slot(nowhere, cv::KeyPoint(), -1);
      world.add_slot(world.new_point(random, {0, 0, 5}), cv::KeyPoint(), -1);
      world.frame.mvKeysUn.back().pt.y = nan;
      const std::size_t size = world.frame.mvpMapPoints.size();
      OrbSlam2 good(budget);
      good.use_covariances = true;
      good.options.time_limit = has_error ? -1 : 0;
      const std::set<std::size_t> optimised = slots_optimised_with(good, world);
      EXPECT_EQ(optimised.size(), has_error ? 400U : std::min<std::size_t>(budget, 400));
      for (const std::size_t slot : {size - 2, size - 1}) {
        EXPECT_EQ(optimised.count(slot), 0U);
        EXPECT_TRUE(world.frame.mvbOutlier[slot]);
      }
    }
  }
}

TEST(OrbSlam2Adapter, matches_come_back_if_the_optimiser_throws) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 400, true);
  const std::vector<MapPoint*> before = world.frame.mvpMapPoints;
  OrbSlam2 good(100);
  const auto fail = [&](Frame* frame) -> int {
    EXPECT_NE(frame->mvpMapPoints, before);
    throw std::runtime_error("no convergence");
  };
  EXPECT_THROW(good.optimize(world.frame, fail), std::runtime_error);
  EXPECT_EQ(world.frame.mvpMapPoints, before);
}

TEST(OrbSlam2Adapter, a_recorded_frame_has_all_matches_as_they_were_before_the_optimisation) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool stereo : {false, true}) {
    World world(random, 300, stereo);
    const TemporaryFolder folder;
    OrbSlam2 good(100);
    good.use_covariances = stereo;
    ASSERT_TRUE(good.record(folder.path().c_str()));
    const RigidTransform T_cw(world.frame.mTcw);
    good.optimize(world.frame, ORB_SLAM2::Optimizer::PoseOptimization);
    const RecordedFrame recorded(folder / "frame_000000.csv");
    EXPECT_EQ(recorded.numbers("Tcw_prior"), std::vector<double>(T_cw.data(), T_cw.data() + 12));
    EXPECT_EQ(recorded.numbers("fx,fy,cx,cy,bf"), (std::vector<double>{458, 457, 367, 248, stereo ? 50.0 : 0.0}));
    ASSERT_EQ(recorded.rows.size(), 300U);
    for (std::size_t row = 0; row < 300; ++row) {
      const auto slot = static_cast<std::size_t>(recorded.at(row, "kp"));
      MapPoint& point = *world.frame.mvpMapPoints[slot];
      const sim::Match match = match_of(world.frame, slot);
      EXPECT_EQ(recorded.at(row, "mp_id"), static_cast<double>(point.mnId));
      EXPECT_EQ(recorded.at(row, "keyframe"), static_cast<double>(point.mnFirstKFid));
      EXPECT_EQ(recorded.at(row, "X"), match.point[0]);
      EXPECT_EQ(recorded.at(row, "u"), match.u);
      EXPECT_EQ(recorded.at(row, "v"), match.v);
      EXPECT_NEAR(recorded.at(row, "inv_sigma2"), match.inv_sigma2, 1e-6);
      EXPECT_EQ(recorded.at(row, "selected"), good.features.is_selected(row) ? 1 : 0);
      if (!stereo) continue;
      EXPECT_EQ(recorded.at(row, "u_right"), match.is_stereo() ? match.u_right : -1);
      const Eigen::Matrix3d covariance = covariance_of(point);
      EXPECT_NEAR(recorded.at(row, "cov_zz"), covariance(2, 2), 1e-3 * covariance(2, 2));
    }
  }
}

TEST(OrbSlam2Adapter, the_log_has_a_line_a_frame_of_what_cost_says) {
  Random random;
  SCOPED_TRACE(random.name());
  OrbSlam2 good(100);
  EXPECT_STREQ(good.cost().status, "none");
  EXPECT_FALSE(good.log.open("/no/such/folder/hook.csv"));
  char name[] = "/tmp/maxlogdet_log_XXXXXX";
  const int file = mkstemp(name);
  ASSERT_GE(file, 0);
  ::close(file);
  ASSERT_TRUE(good.log.open(name));
  std::string expected = "frame,status,candidates,selected,gather_ns,select_ns,optimize_ns,restore_ns\n";
  int frame = 0;
  for (const std::size_t n : {400U, 90U}) {
    World world(random, n, true);
    good.optimize(world.frame, ORB_SLAM2::Optimizer::PoseOptimization);
    const HookCost& cost = good.cost();
    EXPECT_STREQ(cost.status, n > 100 ? "ok" : "all_selected");
    EXPECT_EQ(cost.candidates, n);
    EXPECT_EQ(cost.selected, std::min<std::size_t>(n, 100));
    for (const double us : {cost.gather_us, cost.select_us, cost.optimize_us, cost.restore_us}) EXPECT_GE(us, 0);
    EXPECT_EQ(cost.hook_us(), cost.gather_us + cost.select_us + cost.restore_us);
    char line[200];
    const auto ns = [](double us) { return static_cast<long long>(1000 * us); };
    std::snprintf(line, sizeof line, "%d,%s,%zu,%zu,%lld,%lld,%lld,%lld\n", frame++, cost.status, cost.candidates,
                  cost.selected, ns(cost.gather_us), ns(cost.select_us), ns(cost.optimize_us), ns(cost.restore_us));
    expected += line;
  }
  good.log = HookLog();  // closes the file
  std::ifstream written(name);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(written), {}), expected);
  std::remove(name);
}

}  // namespace
}  // namespace maxlogdet::test
