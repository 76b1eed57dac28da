// SPDX-License-Identifier: MIT
// The guide's code for ORB-SLAM2, run: blocks, the optimisation with the selected matches alone, active matching. The
// optimiser behind the stand-in is that of the simulations, which rejects outliers as ORB-SLAM2 does.
#include "tests/integration/orb_slam2_snippets.hpp"

#include "sim/outlier_rejection.hpp"
#include "tests/integration/oracle.hpp"
#include "tests/linear_algebra.hpp"
#include "tests/support.hpp"

#include <array>
#include <memory>
#include <numeric>
#include <set>

namespace {

// What the stand-ins were asked for.
struct Calls {
  std::vector<std::size_t> optimised;              // keypoints whose map points entered the optimiser
  std::vector<ORB_SLAM2::MapPoint*> tried;         // points that the matcher was asked for, one by one
  std::set<const ORB_SLAM2::MapPoint*> matchable;  // points that it finds
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
  match.inv_sigma2 = frame.mvInvLevelSigma2[static_cast<std::size_t>(match.octave)];
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
int ORBmatcher::SearchByProjection(Frame& F, const std::vector<MapPoint*>& vpMapPoints, float /*th*/) {
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

}  // namespace ORB_SLAM2

namespace maxlogdet::test {
namespace {

using ORB_SLAM2::Frame;
using ORB_SLAM2::MapPoint;

// A frame with `n` matches, every fourth of its slots empty besides; every eighth match is off by 2 to 20 deviations,
// every second one stereo. The frame's pose is a guess some ten centimetres beside the true one.
struct World {
  World(Random& random, std::size_t n, bool stereo) : T_cw(random_pose(random)) {
    calls = Calls();
    frame.mbf = stereo ? 50 : 0;
    for (int level = 0; level < 8; ++level) {
      const auto scale = static_cast<float>(std::pow(1.2, level));
      frame.mvScaleFactors.push_back(scale);
      frame.mvInvLevelSigma2.push_back(1 / (scale * scale));
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (i % 3 == 0) add_slot(nullptr, cv::KeyPoint(), -1);
      add_match(random, i % 8 == 5, stereo && i % 2 == 0);
    }
    frame.N = static_cast<int>(frame.mvpMapPoints.size());
    sim::Vector6 xi;
    xi << random_vector(random, 0.1), random_vector(random, 0.02);
    frame.SetPose(to_mat(sim::exp_se3(xi) * T_cw));
  }

  // Its covariance as one stereo observation from where the camera is leaves it.
  MapPoint* new_point(const Eigen::Vector3d& in_camera) {
    const Eigen::Vector3d p = T_cw.inverse() * in_camera;
    points.push_back(std::make_unique<MapPoint>());
    const Eigen::Matrix3d information =
        information_of_point({Frame::fx, Frame::fy, 0, 0, 50}, T_cw.matrix().topRows<3>(), p, 1);
    points.back()->SetCovariance((information_of_new_point() + information).inverse());
    points.back()->mWorldPos = cv::Mat(3, 1);
    for (int row = 0; row < 3; ++row) points.back()->mWorldPos.at<float>(row) = static_cast<float>(p(row));
    return points.back().get();
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
    add_slot(new_point(p), key, stereo ? static_cast<float>(right) : -1);
  }

  std::size_t match_count() const {
    return frame.mvpMapPoints.size() -
           static_cast<std::size_t>(std::count(frame.mvpMapPoints.begin(), frame.mvpMapPoints.end(), nullptr));
  }

  sim::Pose T_cw;
  Frame frame;
  std::vector<std::unique_ptr<MapPoint>> points;
};

SeenPoint seen_point(const Frame& frame, const Eigen::Vector3d& p, double bf, double sigma,
                     const Eigen::Matrix3d& covariance) {
  const sim::Pose T_cw = pose_in_double(frame);
  return {T_cw * p, bf, Frame::fx, Frame::fy, sigma, T_cw.linear() * covariance * T_cw.linear().transpose()};
}

std::vector<SeenPoint> seen_points(const Frame& frame, const std::vector<std::size_t>& slots) {
  std::vector<SeenPoint> points;
  for (const std::size_t i : slots) {
    const sim::Match match = match_of(frame, i);
    const Eigen::Vector3d p(match.point[0], match.point[1], match.point[2]);
    points.push_back(seen_point(frame, p, match.is_stereo() ? frame.mbf : 0.0, 1 / std::sqrt(match.inv_sigma2),
                                frame.mvpMapPoints[i]->GetCovariance()));
  }
  return points;
}

TEST(OrbSlam2Guide, blocks_are_derivatives_of_the_projection_under_a_left_perturbation) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool stereo : {false, true}) {
    const World world(random, 100, stereo);
    GoodFeatures good(1000);
    ASSERT_TRUE(ORB_SLAM2::build_blocks(world.frame, good));
    ASSERT_EQ(good.blocks.size(), world.frame.mvpMapPoints.size());
    BlockStore filled;
    std::vector<std::size_t> slots;
    for (std::size_t i = 0; i < good.blocks.size(); ++i) {
      EXPECT_EQ(good.blocks.is_valid(i), world.frame.mvpMapPoints[i] != nullptr) << i;
      if (!good.blocks.is_valid(i)) continue;
      EXPECT_NEAR(good.sigmas[i], std::pow(1.2, world.frame.mvKeysUn[i].octave), 1e-5);
      slots.push_back(i);
      push_back(filled, stored_block(good.blocks, i));
    }
    EXPECT_LT(largest_difference(filled, seen_points(world.frame, slots)), 1e-4);
  }
}

// Against derivatives by differences, summed over keyframes that saw it with one camera or two; a bad one does not
// count.
TEST(OrbSlam2Guide, the_covariance_of_a_point_is_what_its_keyframes_leave) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 0, true);
  const Eigen::Vector3d p_w = random_point_in_camera(random);
  MapPoint point;
  point.mWorldPos = cv::Mat(3, 1);
  for (int row = 0; row < 3; ++row) point.mWorldPos.at<float>(row) = static_cast<float>(p_w(row));
  EXPECT_TRUE(std::isnan(point.GetCovariance()(0, 0)));

  std::vector<ORB_SLAM2::KeyFrame> keyframes(5);
  Eigen::Matrix3d expected = 1e-6 * Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    ORB_SLAM2::KeyFrame& keyframe = keyframes[k];
    sim::Vector6 xi;
    xi << random_vector(random, 0.5), random_vector(random, 0.2);
    keyframe.Tcw = to_mat(sim::exp_se3(xi));
    keyframe.mbf = 50;
    keyframe.mbBad = k == 4;
    keyframe.mvKeysUn.resize(k + 1);
    keyframe.mvKeysUn[k].octave = k == 1 ? 3 : 0;
    keyframe.mvuRight.assign(k + 1, k % 2 == 0 ? 100.0F : -1.0F);
    keyframe.mvInvLevelSigma2 = {1, 0.7F, 0.5F, 0.3F};
    point.mObservations[&keyframe] = k;
    if (keyframe.isBad()) continue;
    const sim::Pose T_cw = sim::exp_se3(xi);
    const Derivatives derivatives({T_cw * p_w, k % 2 == 0 ? 50.0 : 0.0, Frame::fx, Frame::fy});
    const Eigen::MatrixXd H_p = derivatives.H_p.topRows(k % 2 == 0 ? 3 : 2) * T_cw.linear();
    expected += (k == 1 ? 0.3 : 1) * gram(H_p);
  }
  ORB_SLAM2::update_covariance(point);
  EXPECT_LT((point.GetCovariance() * expected - Eigen::Matrix3d::Identity()).norm(), 1e-3);
}

TEST(OrbSlam2Guide, chi2_is_that_of_the_optimiser) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 100, true);
  for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
    if (world.frame.mvpMapPoints[i] == nullptr) continue;
    const double expected =
        sim::chi2(camera_in_double(world.frame), pose_in_double(world.frame), match_of(world.frame, i), true);
    EXPECT_NEAR(ORB_SLAM2::chi2_of(world.frame, i), expected, 1e-6 * (1 + expected));
  }
}

TEST(OrbSlam2Guide, a_point_behind_the_camera_is_an_outlier) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 3, false);
  world.add_slot(world.new_point({0, 0, -5}), cv::KeyPoint(), -1);
  EXPECT_GT(ORB_SLAM2::chi2_of(world.frame, world.frame.mvpMapPoints.size() - 1), 1e300);
}

// What the guide promises of optimize_with_selected: see the names.
TEST(OrbSlam2Guide, only_selected_matches_enter_the_optimiser_and_none_stays_null) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool stereo : {false, true}) {
    World world(random, 400, stereo);
    world.frame.mvpMapPoints[1]->mbBad = true;
    const std::vector<MapPoint*> before = world.frame.mvpMapPoints;

    GoodFeatures good(1000);
    ASSERT_TRUE(ORB_SLAM2::build_blocks(world.frame, good));
    Options options;
    std::set<std::size_t> selected;
    for (const auto i : good.selector.select(good.blocks, options)) selected.insert(i);

    const int inliers =
        optimize_with_selected(world.frame, good, options.budget, ORB_SLAM2::Optimizer::PoseOptimization);
    EXPECT_EQ(calls.optimiser_calls, 1);
    EXPECT_EQ(std::set<std::size_t>(calls.optimised.begin(), calls.optimised.end()), selected);
    EXPECT_EQ(selected.size(), 100);
    EXPECT_EQ(selected.count(1), 0) << "a bad point";
    EXPECT_EQ(world.frame.mvpMapPoints, before);
    EXPECT_GT(inliers, 300) << "of 350 true ones, not only of the selected";
  }
}

TEST(OrbSlam2Guide, outlier_flags_follow_chi2_under_the_new_pose_and_inliers_are_counted) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool stereo : {false, true}) {
    World world(random, 400, stereo);
    const Frame guess = world.frame;
    // Flags left over from before, right or wrong, must not matter.
    for (auto&& flag : world.frame.mvbOutlier) flag = random.chance(0.5);
    GoodFeatures good(1000);
    const int inliers = optimize_with_selected(world.frame, good, 100, ORB_SLAM2::Optimizer::PoseOptimization);

    int counted = 0, differs_from_guess = 0;
    for (std::size_t i = 0; i < world.frame.mvpMapPoints.size(); ++i) {
      if (world.frame.mvpMapPoints[i] == nullptr) continue;
      const sim::Match match = match_of(world.frame, i);
      const double threshold = match.is_stereo() ? 7.815 : 5.991;
      const double chi2 = sim::chi2(camera_in_double(world.frame), pose_in_double(world.frame), match, true);
      if (!world.frame.mvbOutlier[i]) ++counted;
      if (std::abs(chi2 - threshold) < 0.01) continue;  // the optimiser judged with a pose of double
      EXPECT_EQ(world.frame.mvbOutlier[i], chi2 > threshold) << "match " << i << ", chi2 " << chi2;
      if ((ORB_SLAM2::chi2_of(guess, i) > threshold) != (chi2 > threshold)) ++differs_from_guess;
    }
    EXPECT_EQ(inliers, counted);
    EXPECT_GT(differs_from_guess, 20) << "the guess is too good for this test";
    EXPECT_LT((pose_in_double(world.frame) * world.T_cw.inverse()).translation().norm(), 0.03);
  }
}

TEST(OrbSlam2Guide, tracking_counts_all_inliers_not_only_the_selected) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 400, true);
  ORB_SLAM2::Tracking tracking;
  tracking.mCurrentFrame = world.frame;
  EXPECT_TRUE(tracking.TrackLocalMap());
  EXPECT_EQ(calls.optimised.size(), 100);
  EXPECT_GT(tracking.mnMatchesInliers, 300);
  int found = 0;
  for (const auto& point : world.points) found += point->mnFound - 1;
  EXPECT_EQ(found, tracking.mnMatchesInliers);
}

TEST(OrbSlam2Guide, all_matches_are_used_when_there_is_no_selection) {
  Random random;
  SCOPED_TRACE(random.name());
  const auto optimise = ORB_SLAM2::Optimizer::PoseOptimization;
  {
    World world(random, 90, true);  // fewer than the budget
    GoodFeatures good(1000);
    EXPECT_GT(optimize_with_selected(world.frame, good, 100, optimise), 60);
    EXPECT_EQ(calls.optimised.size(), world.match_count());
  }
  {
    World world(random, 400, true);
    GoodFeatures good(300);  // too small for the slots of this frame
    EXPECT_GT(optimize_with_selected(world.frame, good, 100, optimise), 300);
    EXPECT_EQ(calls.optimised.size(), world.match_count());
  }
  {
    World world(random, 400, true);
    world.frame.mTcw.at<float>(0, 0) = 5;  // no rotation
    GoodFeatures good(1000);
    optimize_with_selected(world.frame, good, 100, optimise);
    EXPECT_EQ(calls.optimised.size(), world.match_count());
  }
  {
    World world(random, 400, true);
    world.frame.mTcw = cv::Mat();
    GoodFeatures good(1000);
    optimize_with_selected(world.frame, good, 100, optimise);
    EXPECT_EQ(calls.optimised.size(), world.match_count());
  }
}

// 60 matches of the motion model, empty slots, and 300 local map points, of which two thirds can be matched.
struct LocalMap {
  explicit LocalMap(Random& random) : world(random, 60, true) {
    for (int i = 0; i < 250; ++i) world.add_slot(nullptr, cv::KeyPoint(), -1);
    for (int i = 0; i < 300; ++i) {
      MapPoint* const point = world.new_point(random_point_in_camera(random));
      point->mbTrackInView = i % 10 != 7;
      point->mbBad = i % 25 == 3;
      point->mnTrackScaleLevel = random.integer(0, 7);
      if (random.chance(0.67)) calls.matchable.insert(point);
      points.push_back(point);
    }
  }
  World world;
  std::vector<MapPoint*> points;
};

TEST(OrbSlam2Guide, active_matching_tries_one_point_after_the_other_until_enough_are_matched) {
  Random random;
  SCOPED_TRACE(random.name());
  LocalMap map(random);
  const std::size_t before = map.world.match_count();
  ORB_SLAM2::ORBmatcher matcher;
  ActiveFeatures features(2000);
  EXPECT_EQ(ORB_SLAM2::match_selected(map.world.frame, map.points, 1, 50, matcher, features), 50);
  EXPECT_EQ(map.world.match_count(), before + 50);
  EXPECT_EQ(calls.matcher_calls, static_cast<int>(calls.tried.size()));
  EXPECT_LT(calls.tried.size(), 150U);
  const std::set<MapPoint*> tried(calls.tried.begin(), calls.tried.end());
  EXPECT_EQ(tried.size(), calls.tried.size()) << "a point was tried twice";
  for (MapPoint* const point : map.points) {
    EXPECT_EQ(point->mnVisible, tried.count(point) > 0 ? 2 : 1);
    if (!point->mbTrackInView || point->mbBad) {
      EXPECT_EQ(tried.count(point), 0U);
    }
  }
}

// The same answers to a greedy search written down here: matches of the frame first, then the best of what is left.
TEST(OrbSlam2Guide, active_matching_tries_points_in_the_order_of_what_they_add_to_the_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  LocalMap map(random);
  const Frame frame = map.world.frame;
  Matrix6 information = 1e-5 * Matrix6::Identity();
  for (std::size_t i = 0; i < frame.mvpMapPoints.size(); ++i) {
    if (frame.mvpMapPoints[i] == nullptr) continue;
    information += information_of(seen_points(frame, {i})[0]);
  }
  std::vector<MapPoint*> left;
  for (MapPoint* const point : map.points) {
    if (point->mbTrackInView && !point->mbBad) left.push_back(point);
  }
  std::vector<MapPoint*> expected;
  for (int matched = 0; matched < 20;) {
    std::size_t best = 0;
    double best_log_det = -HUGE_VAL;
    Matrix6 best_information = Matrix6::Zero();
    for (std::size_t j = 0; j < left.size(); ++j) {
      const cv::Mat p = left[j]->GetWorldPos();
      const Eigen::Vector3d p_w(p.at<float>(0), p.at<float>(1), p.at<float>(2));
      const double sigma = frame.mvScaleFactors[static_cast<std::size_t>(left[j]->mnTrackScaleLevel)];
      const Matrix6 added = information_of(seen_point(frame, p_w, 0, sigma, left[j]->GetCovariance()));
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
  ORB_SLAM2::ORBmatcher matcher;
  ActiveFeatures features(2000);
  EXPECT_EQ(ORB_SLAM2::match_selected(map.world.frame, map.points, 1, 20, matcher, features), 20);
  EXPECT_EQ(calls.tried, expected);
}

TEST(OrbSlam2Guide, active_matching_tries_all_points_if_it_cannot_select) {
  Random random;
  SCOPED_TRACE(random.name());
  for (const bool has_pose : {false, true}) {
    LocalMap map(random);
    if (!has_pose) map.world.frame.mTcw = cv::Mat();
    ORB_SLAM2::ORBmatcher matcher;
    ActiveFeatures features(has_pose ? 100 : 2000);  // too small, or no pose
    EXPECT_GT(ORB_SLAM2::match_selected(map.world.frame, map.points, 1, 50, matcher, features), 100);
    EXPECT_EQ(calls.matcher_calls, 1);
    for (MapPoint* const point : map.points) EXPECT_EQ(point->mnVisible, point->mbTrackInView ? 2 : 1);
  }
}

}  // namespace
}  // namespace maxlogdet::test
