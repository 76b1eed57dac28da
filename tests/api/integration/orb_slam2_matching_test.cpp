// SPDX-License-Identifier: MIT
// The adapter of ORB-SLAM2 and the guide's lines for it: active matching.
#include "tests/api/integration/orb_slam2_world.hpp"
#include "tests/support/linear_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace maxlogdet::test {
namespace {

// 60 matches of the motion model, empty slots, and 300 local map points, of which two thirds can be matched.
struct LocalMap {
  explicit LocalMap(Random& random) : world(random, 60, true) {
    for (int i = 0; i < 250; ++i) world.add_slot(nullptr, cv::KeyPoint(), -1);
    for (int i = 0; i < 300; ++i) {
      MapPoint* const point = world.new_point(random, random_point_in_camera(random));
      point->mbTrackInView = i % 10 != 7;
      point->mbBad = i % 25 == 3;
      point->mnTrackScaleLevel = random.integer(0, 7);
      if (random.chance(0.67)) calls.matchable.insert(point);
      tracking.mvpLocalMapPoints.push_back(point);
    }
    tracking.mCurrentFrame = world.frame;
  }

  std::size_t match_count() const {
    const std::vector<MapPoint*>& slots = tracking.mCurrentFrame.mvpMapPoints;
    return slots.size() - static_cast<std::size_t>(std::count(slots.begin(), slots.end(), nullptr));
  }

  World world;
  ORB_SLAM2::Tracking tracking;
};

TEST(OrbSlam2Adapter, active_matching_tries_one_point_after_the_other_until_enough_are_matched) {
  Random random;
  SCOPED_TRACE(random.name());
  LocalMap map(random);
  const std::size_t before = map.match_count();
  map.tracking.mGoodFeatures.max_new = 50;
  map.tracking.SearchLocalPoints();
  EXPECT_EQ(map.match_count(), before + 50);
  EXPECT_EQ(calls.matcher_calls, static_cast<int>(calls.tried.size()));
  EXPECT_LT(calls.tried.size(), 150U);
  const std::set<MapPoint*> tried(calls.tried.begin(), calls.tried.end());
  EXPECT_EQ(tried.size(), calls.tried.size()) << "a point was tried twice";
  // What SearchLocalPoints has counted as visible is given back where match() never looked.
  for (MapPoint* const point : map.tracking.mvpLocalMapPoints) {
    EXPECT_EQ(point->mnVisible, tried.count(point) > 0 ? 2 : 1);
    if (!point->mbTrackInView || point->mbBad) {
      EXPECT_EQ(tried.count(point), 0U);
    }
  }
}

// The same answers to a greedy search written down here: matches of the frame first, then the best of what is left.
TEST(OrbSlam2Adapter, active_matching_tries_points_in_the_order_of_what_they_add_to_the_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  LocalMap map(random);
  const Frame frame = map.tracking.mCurrentFrame;
  Matrix6 information = 1e-5 * Matrix6::Identity();
  for (const SeenPoint& seen : seen_matches(frame, true)) information += information_of(seen);
  std::vector<MapPoint*> left;
  for (MapPoint* const point : map.tracking.mvpLocalMapPoints) {
    if (point->mbTrackInView && !point->mbBad) left.push_back(point);
  }
  std::vector<MapPoint*> expected;
  for (int matched = 0; matched < 20;) {
    std::size_t best = 0;
    double best_log_det = -HUGE_VAL;
    Matrix6 best_information = Matrix6::Zero();
    for (std::size_t j = 0; j < left.size(); ++j) {
      const double sigma = frame.mvScaleFactors[static_cast<std::size_t>(left[j]->mnTrackScaleLevel)];
      const SeenPoint seen = seen_point(frame, position_of(*left[j]), 0, sigma, covariance_of(*left[j]));
      const Matrix6 added = information_of(seen);
      const double with_it = log_det(information + added);
      if (with_it > best_log_det) best = j, best_log_det = with_it, best_information = added;
    }
    expected.push_back(left[best]);
    if (calls.matchable.count(left[best]) > 0) {
      information += best_information;
      ++matched;
    }
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  OrbSlam2& good = map.tracking.mGoodFeatures;
  good.use_covariances = true;
  good.max_new = 20;
  ORB_SLAM2::ORBmatcher matcher;
  EXPECT_EQ(good.match(map.tracking.mCurrentFrame, map.tracking.mvpLocalMapPoints, matcher, 1), 20);
  EXPECT_EQ(calls.tried, expected);
}

TEST(OrbSlam2Adapter, active_matching_tries_all_points_if_it_cannot_select) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool has_pose : {false, true}) {
    LocalMap map(random);
    if (!has_pose) map.tracking.mCurrentFrame.mTcw = cv::Mat();
    map.tracking.mGoodFeatures = OrbSlam2(100, has_pose ? 100 : 2000);  // too small, or no pose
    map.tracking.SearchLocalPoints();
    EXPECT_GT(map.match_count(), 160U);
    EXPECT_EQ(calls.matcher_calls, 1);
    for (MapPoint* const point : map.tracking.mvpLocalMapPoints) {
      EXPECT_EQ(point->mnVisible, point->mbTrackInView && !point->mbBad ? 2 : 1);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
