// SPDX-License-Identifier: MIT
// The adapter of ORB-SLAM2 and the guide's lines for it: blocks, covariances, the optimisation with the selected
// matches alone, active matching. The optimiser behind the stand-in is that of the simulations, which rejects outliers
// as ORB-SLAM2 does.
#include "tests/api/integration/orb_slam2_snippets.hpp"

#include "sim/outlier_rejection.hpp"
#include "tests/api/integration/oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>

namespace {

// What the stand-ins were asked for.
struct Calls {
  std::vector<std::size_t> optimised;              // keypoints whose map points entered the optimiser
  std::vector<ORB_SLAM2::MapPoint*> tried;         // points that the matcher was asked for, one by one
  std::set<const ORB_SLAM2::MapPoint*> matchable;  // points that it finds
  std::map<std::size_t, Eigen::Matrix3d> weights;  // by keypoint, of the edges of stereo matches
  int optimiser_calls = 0;
  int matcher_calls = 0;
};
Calls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

maxlogdet::PinholeCamera camera_in_double(const ORB_SLAM2::Frame& frame) {
  return {ORB_SLAM2::Frame::fx, ORB_SLAM2::Frame::fy, ORB_SLAM2::Frame::cx, ORB_SLAM2::Frame::cy, frame.mbf};
}

maxlogdet::sim::Pose pose_in_double(const ORB_SLAM2::Frame& frame) {
  maxlogdet::sim::Pose T_cw = maxlogdet::sim::Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) T_cw.matrix()(row, column) = frame.mTcw.at<float>(row, column);
  }
  return T_cw;
}

maxlogdet::sim::Match match_of(const ORB_SLAM2::Frame& frame, std::size_t i) {
  maxlogdet::sim::Match match;
  const cv::Mat p = frame.mvpMapPoints[i]->GetWorldPos();
  for (int row = 0; row < 3; ++row) match.point[row] = p.at<float>(row);
  match.u = frame.mvKeysUn[i].pt.x;
  match.v = frame.mvKeysUn[i].pt.y;
  match.octave = frame.mvKeysUn[i].octave;
  match.u_right = frame.mvuRight[i];
  match.inv_sigma2 = std::pow(frame.mvScaleFactors[static_cast<std::size_t>(match.octave)], -2.0);
  return match;
}

cv::Mat to_mat(const maxlogdet::sim::Pose& T_cw) {
  cv::Mat mat(4, 4);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      mat.at<float>(row, column) = static_cast<float>(T_cw.matrix()(row, column));
    }
  }
  return mat;
}

}  // namespace

namespace ORB_SLAM2 {

float Frame::fx = 458;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::fy = 457;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cx = 367;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cy = 248;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

// With every match that is not null, whatever its flag; sets flags and the pose.
int Optimizer::PoseOptimization(Frame* pFrame) {
  using namespace maxlogdet::sim;
  calls.optimised.clear();
  ++calls.optimiser_calls;
  std::vector<Match> matches;
  for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
    if (pFrame->mvpMapPoints[i] == nullptr) continue;
    pFrame->mvbOutlier[i] = false;
    calls.optimised.push_back(i);
    matches.push_back(match_of(*pFrame, i));
  }
  if (matches.size() < 3 || pFrame->mTcw.empty()) return 0;
  std::vector<std::uint32_t> all(matches.size());
  std::iota(all.begin(), all.end(), 0U);
  const Rejection rejection =
      reject_outliers(camera_in_double(*pFrame), matches, all, pose_in_double(*pFrame), RejectionOptions());
  for (const std::size_t i : calls.optimised) pFrame->mvbOutlier[i] = true;
  for (const std::uint32_t i : rejection.inliers) pFrame->mvbOutlier[calls.optimised[i]] = false;
  pFrame->SetPose(to_mat(rejection.estimate.T_cw));
  return static_cast<int>(rejection.inliers.size());
}

// Finds what it is told to find, in the next free slot.
int ORBmatcher::SearchByProjection(Frame& F, const std::vector<MapPoint*>& vpMapPoints, const float /*th*/) {
  ++calls.matcher_calls;
  int matches = 0;
  for (MapPoint* const point : vpMapPoints) {
    if (!point->mbTrackInView || point->isBad()) continue;
    calls.tried.push_back(point);
    if (calls.matchable.count(point) == 0) continue;
    for (MapPoint*& slot : F.mvpMapPoints) {
      if (slot != nullptr) continue;
      slot = point;
      ++matches;
      break;
    }
  }
  return matches;
}

// Asks what each stereo match weighs, and optimises nothing.
int weighted::Optimizer::PoseOptimization(Frame* pFrame, const maxlogdet::OrbSlam2* good) {
  calls.weights.clear();
  for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
    if (pFrame->mvpMapPoints[i] == nullptr || pFrame->mvuRight[i] < 0) continue;
    calls.weights[i] = information_of_edge(pFrame, i, good);
  }
  return 0;
}

}  // namespace ORB_SLAM2

namespace maxlogdet::test {
namespace {

using ORB_SLAM2::Frame;
using ORB_SLAM2::MapPoint;

// A frame with `n` matches, every fourth of its slots empty besides; every eighth match is off by 2 to 20 deviations,
// every second one stereo. The frame's pose is a guess some ten centimetres beside the true one. Three keyframes nearby
// have observed every point, at random octaves, one in stereo.
struct World {
  World(Random& random, std::size_t n, bool stereo) : T_cw(random_pose(random)) {
    calls = Calls();
    frame.mbf = stereo ? 50 : 0;
    for (int level = 0; level < 8; ++level) frame.mvScaleFactors.push_back(static_cast<float>(std::pow(1.2, level)));
    for (int k = 0; k < 3; ++k) {
      keyframes.push_back(std::make_unique<ORB_SLAM2::KeyFrame>());
      keyframes.back()->Tcw = to_mat(near(random, 0.4, 0.05));
      keyframes.back()->mbf = 50;
      keyframes.back()->mvScaleFactors = frame.mvScaleFactors;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (i % 3 == 0) add_slot(nullptr, cv::KeyPoint(), -1);
      add_match(random, i % 8 == 5, stereo && i % 2 == 0);
    }
    frame.N = static_cast<int>(frame.mvpMapPoints.size());
    frame.SetPose(to_mat(near(random, 0.1, 0.02)));
  }

  sim::Pose near(Random& random, double metres, double radians) const {
    sim::Vector6 xi;
    xi << random_vector(random, metres), random_vector(random, radians);
    return sim::exp_se3(xi) * T_cw;
  }

  MapPoint* new_point(Random& random, const Eigen::Vector3d& in_camera) {
    const Eigen::Vector3d p = T_cw.inverse() * in_camera;
    points.push_back(std::make_unique<MapPoint>());
    MapPoint& point = *points.back();
    point.mnId = points.size();
    point.mWorldPos = cv::Mat(3, 1);
    for (int row = 0; row < 3; ++row) point.mWorldPos.at<float>(row) = static_cast<float>(p(row));
    for (const auto& keyframe : keyframes) observe(random, point, *keyframe, keyframe == keyframes[0]);
    return &point;
  }

  static void observe(Random& random, MapPoint& point, ORB_SLAM2::KeyFrame& keyframe, bool stereo) {
    point.mObservations[&keyframe] = keyframe.mvKeysUn.size();
    keyframe.mvKeysUn.emplace_back();
    keyframe.mvKeysUn.back().octave = random.integer(0, 7);
    keyframe.mvuRight.push_back(stereo ? 100 : -1);
    point.nObs += stereo ? 2 : 1;
  }

  void add_slot(MapPoint* point, const cv::KeyPoint& key, float u_right) {
    frame.mvpMapPoints.push_back(point);
    frame.mvKeysUn.push_back(key);
    frame.mvuRight.push_back(u_right);
    frame.mvbOutlier.push_back(false);
  }

  void add_match(Random& random, bool outlier, bool stereo) {
    const Eigen::Vector3d p = random_point_in_camera(random);
    cv::KeyPoint key;
    key.octave = random.integer(0, 7);
    const double sigma = std::pow(1.2, key.octave);
    const double offset = outlier ? random.uniform(2, random.chance(0.5) ? 3.5 : 20) * sigma : 0;
    const double u = Frame::fx * p.x() / p.z() + Frame::cx;
    const double v = Frame::fy * p.y() / p.z() + Frame::cy;
    key.pt.x = static_cast<float>(u + random.uniform(-1, 1) * sigma + offset);
    key.pt.y = static_cast<float>(v + random.uniform(-1, 1) * sigma);
    const double right = u - frame.mbf / p.z() + random.uniform(-1, 1) * sigma;
    add_slot(new_point(random, p), key, stereo ? static_cast<float>(right) : -1);
  }

  std::size_t match_count() const {
    return frame.mvpMapPoints.size() -
           static_cast<std::size_t>(std::count(frame.mvpMapPoints.begin(), frame.mvpMapPoints.end(), nullptr));
  }

  sim::Pose T_cw;
  Frame frame;
  std::vector<std::unique_ptr<ORB_SLAM2::KeyFrame>> keyframes;
  std::vector<std::unique_ptr<MapPoint>> points;
};

Eigen::Vector3d position_of(MapPoint& point) {
  const cv::Mat p = point.GetWorldPos();
  return {p.at<float>(0), p.at<float>(1), p.at<float>(2)};
}

// Against derivatives by differences, summed over the keyframes that are not bad.
Eigen::Matrix3d covariance_of(MapPoint& point) {
  const Eigen::Vector3d p_w = position_of(point);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const auto& observation : point.GetObservations()) {
    ORB_SLAM2::KeyFrame& keyframe = *observation.first;
    if (keyframe.isBad()) continue;
    sim::Pose T_cw = sim::Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) T_cw.matrix()(row, column) = keyframe.Tcw.at<float>(row, column);
    }
    const bool stereo = keyframe.mvuRight[observation.second] >= 0;
    const Derivatives derivatives({T_cw * p_w, stereo ? keyframe.mbf : 0.0, keyframe.fx, keyframe.fy});
    const Eigen::MatrixXd H_p = derivatives.H_p.topRows(stereo ? 3 : 2) * T_cw.linear();
    information += std::pow(1.2, -2 * keyframe.mvKeysUn[observation.second].octave) * gram(H_p);
  }
  return inverse(information + 1e-8 * information.trace() * Eigen::Matrix3d::Identity());
}

SeenPoint seen_point(const Frame& frame, const Eigen::Vector3d& p, double bf, double sigma,
                     const Eigen::Matrix3d& covariance) {
  const sim::Pose T_cw = pose_in_double(frame);
  return {T_cw * p, bf, Frame::fx, Frame::fy, sigma, T_cw.linear() * covariance * T_cw.linear().transpose()};
}

SeenPoint seen_match(const Frame& frame, std::size_t slot, bool with_covariance) {
  const sim::Match match = match_of(frame, slot);
  MapPoint& point = *frame.mvpMapPoints[slot];
  return seen_point(frame, position_of(point), match.is_stereo() ? frame.mbf : 0.0, 1 / std::sqrt(match.inv_sigma2),
                    with_covariance ? covariance_of(point) : Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
}

std::vector<SeenPoint> seen_matches(const Frame& frame, bool with_covariance) {
  std::vector<SeenPoint> points;
  for (std::size_t i = 0; i < frame.mvpMapPoints.size(); ++i) {
    if (frame.mvpMapPoints[i] != nullptr) points.push_back(seen_match(frame, i, with_covariance));
  }
  return points;
}

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
// observation tells much.
TEST(OrbSlam2Adapter, covariances_are_computed_anew_when_the_number_of_observations_changes) {
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
  EXPECT_LT(difference_from(after), 1e-4) << "computed anew";
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
      const double threshold = match.is_stereo() ? 7.815 : 5.991;
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
  EXPECT_EQ(calls.optimised.size(), 100U);
  EXPECT_GT(tracking.mnMatchesInliers, 300);
  int found = 0;
  for (const auto& point : world.points) found += point->mnFound - 1;
  EXPECT_EQ(found, tracking.mnMatchesInliers);
}

TEST(OrbSlam2Adapter, all_matches_are_used_when_there_is_no_selection) {
  Random random;
  SCOPED_TRACE(random.name());
  const auto expect_all = [&](OrbSlam2 good, World world, const std::string& why) {
    SCOPED_TRACE(why);
    const std::size_t matches = world.match_count();
    calls = Calls();
    const std::vector<MapPoint*> before = world.frame.mvpMapPoints;
    const int inliers = good.optimize(world.frame, ORB_SLAM2::Optimizer::PoseOptimization);
    EXPECT_EQ(calls.optimised.size(), matches);
    EXPECT_EQ(calls.optimiser_calls, 1);
    EXPECT_EQ(world.frame.mvpMapPoints, before);
    EXPECT_EQ(good.cost().status, why);
    EXPECT_EQ(good.cost().candidates, good.cost().selected);
    if (!world.frame.mTcw.empty() && why != "invalid_pose") {
      EXPECT_GT(inliers, static_cast<int>(matches / 2));
    }
  };
  expect_all(OrbSlam2(100), World(random, 90, true), "all_selected");
  expect_all(OrbSlam2(100, 300), World(random, 400, true), "capacity_exceeded");
  expect_all(OrbSlam2(400, 300), World(random, 290, true), "invalid_budget");
  World world(random, 400, true);
  world.frame.mTcw.at<float>(0, 0) = 5;  // no rotation
  expect_all(OrbSlam2(100), std::move(world), "invalid_pose");
  world = World(random, 400, true);
  world.frame.mTcw = cv::Mat();
  expect_all(OrbSlam2(100), std::move(world), "invalid_pose");
  OrbSlam2 good(100);
  good.options.time_limit = 1e-9;
  expect_all(std::move(good), World(random, 400, true), "deadline_reached");
  good = OrbSlam2(100);
  good.features.block_options.min_depth = -1;
  expect_all(std::move(good), World(random, 400, true), "invalid_options");
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
