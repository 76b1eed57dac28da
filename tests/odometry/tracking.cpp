// SPDX-License-Identifier: MIT
#include "tests/odometry/tracking.hpp"

#include "tests/support/linear_algebra.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace maxlogdet::test {

using sim::Match;
using sim::Pose;
using sim::SelectorKind;
using stereo_odometry::FrameResult;
using stereo_odometry::FrameStatus;
using stereo_odometry::TrackerOptions;

TrackerOptions tracker_options(SelectorKind kind, std::size_t budget) {
  TrackerOptions options;
  options.selection.kind = kind;
  options.selection.budget = budget;
  options.selection.pool = 2 * budget;
  options.selection.search.threads = 1;
  options.selection.blocks.weighting = Weighting::measurement_and_map;
  options.selection.blocks.depth_cue = DepthCue::stereo;
  options.selection.weights = Weighting::measurement_and_map;
  options.optimization.step_tolerance = 1e-6;
  return options;
}

TrackerOptions active_options(std::size_t budget) {
  TrackerOptions options = tracker_options(SelectorKind::md, budget);
  options.active = true;
  return options;
}

TrackerOptions random_order_options(std::size_t budget) {
  TrackerOptions options = active_options(budget);
  options.random_order = true;
  return options;
}

double degrees(double rad) { return rad * 180 / M_PI; }

void Replay::add(const FrameResult& result, const stereo_odometry::StereoFeatures& features) {
  if (!result.is_keyframe) return;
  std::vector<Match> matches;
  std::vector<std::uint32_t> points;
  if (result.status == FrameStatus::initialized) map_.clear();
  for (std::size_t i = 0; i < result.matches.size(); ++i) {
    if (result.is_outlier[i] != 0) continue;
    matches.push_back(result.matches[i]);
    points.push_back(index_of(result.matches[i]));
  }
  map_.add_keyframe(result.T_cw, features, matches, points);
}

std::uint32_t Replay::index_of(const Match& match) const {
  const std::vector<stereo_odometry::MapPoint>& points = map_.points().points;
  const auto found =
      std::lower_bound(points.begin(), points.end(), match.map_point_id,
                       [](const stereo_odometry::MapPoint& point, std::int64_t id) { return point.id < id; });
  EXPECT_TRUE(found != points.end() && found->id == match.map_point_id);
  return static_cast<std::uint32_t>(found - points.begin());
}

namespace {

// The squared error in standard deviations, independent of the code under test.
double chi2_of(const PinholeCamera& camera, const Pose& T_cw, const Match& match, bool is_stereo,
               const Eigen::Matrix3d& map_covariance) {
  const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
  if (p.z() <= 0) return HUGE_VAL;
  Eigen::Matrix3d J;
  J << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()), 0, camera.fy / p.z(),
      -camera.fy * p.y() / (p.z() * p.z()), camera.fx / p.z(), 0, (camera.bf - camera.fx * p.x()) / (p.z() * p.z());
  const Eigen::Vector3d e(match.u - camera.fx * p.x() / p.z() - camera.cx,
                          match.v - camera.fy * p.y() / p.z() - camera.cy,
                          match.u_right - (camera.fx * p.x() - camera.bf) / p.z() - camera.cx);
  const int rows = is_stereo && match.u_right >= 0 ? 3 : 2;
  const Eigen::MatrixXd H_p = product(J.topRows(rows), T_cw.linear());
  Eigen::MatrixXd S = product(H_p, product(map_covariance, H_p.transpose()));
  S.diagonal().array() += 1 / match.inv_sigma2;
  return squared_deviation(e.head(rows), S);
}

void expect_consistent_indices(const FrameResult& result, SelectorKind kind) {
  const std::set<std::uint32_t> inliers(result.inliers.begin(), result.inliers.end());
  const std::set<std::uint32_t> selected(result.selected.begin(), result.selected.end());
  EXPECT_EQ(inliers.size(), result.inliers.size());
  EXPECT_EQ(selected.size(), result.selected.size()) << "without duplicates";
  EXPECT_TRUE(std::includes(inliers.begin(), inliers.end(), selected.begin(), selected.end()));
  ASSERT_FALSE(inliers.empty());
  EXPECT_LT(*inliers.rbegin(), result.matches.size());
  if (!has_budget(kind)) {
    EXPECT_EQ(selected, inliers);
  }
  if (!rejects_outliers(kind)) {
    EXPECT_EQ(inliers.size(), result.matches.size());
  }
}

void expect_consistent_outliers(const FrameResult& result, const PinholeCamera& camera, const TrackerOptions& options,
                                const Replay& map) {
  std::set<std::int64_t> keypoints, points;
  ASSERT_EQ(result.is_outlier.size(), result.matches.size());
  for (std::size_t i = 0; i < result.matches.size(); ++i) {
    const Match& match = result.matches[i];
    keypoints.insert(match.keypoint);
    points.insert(match.map_point_id);
    const Eigen::Matrix3d covariance =
        weighs_map_errors(options.selection) ? map.covariance_of(match) : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
    const double chi2 = chi2_of(camera, result.T_cw, match, options.optimization.stereo, covariance);
    EXPECT_TRUE(std::isfinite(chi2) || chi2 == HUGE_VAL) << i;
    const double limit = options.optimization.stereo && match.u_right >= 0 ? 7.815 : 5.991;
    if (std::abs(chi2 - limit) > 1e-6) {
      EXPECT_EQ(result.is_outlier[i] != 0, chi2 > limit) << i << ' ' << chi2;
    }
  }
  EXPECT_EQ(keypoints.size(), result.matches.size()) << "a keypoint has one point";
  EXPECT_EQ(points.size(), result.matches.size()) << "a point has one keypoint";
}

}  // namespace

void expect_consistent(const FrameResult& result, const PinholeCamera& camera, const TrackerOptions& options,
                       const Replay& map) {
  ASSERT_EQ(result.status, FrameStatus::tracked);
  EXPECT_GE(result.searched, result.matches.size());
  if (has_budget(options.selection.kind)) {
    EXPECT_LE(result.selected.size(), options.selection.budget);
  }
  expect_consistent_indices(result, options.selection.kind);
  expect_consistent_outliers(result, camera, options, map);
  EXPECT_TRUE(std::isfinite(result.log_det));
  if (options.active) {
    EXPECT_TRUE(std::isnan(result.efficiency)) << "other candidates were not matched";
  } else {
    EXPECT_GT(result.efficiency, 0);
    EXPECT_LE(result.efficiency, 1 + 1e-9);
  }
}

void expect_predicted(const std::vector<FrameResult>& results, std::size_t i) {
  const Pose &last = results[i - 1].T_cw, &before = results[i - 2].T_cw;
  const Pose expected = sim::orthonormal(last * before.inverse() * last);
  EXPECT_LT((results[i].T_cw.matrix() - expected.matrix()).norm(), 1e-14) << i;
}

StereoTracking::StereoTracking() {
  for (std::size_t i = 0; i < frames; ++i) features_.push_back(extractor_.extract(world_.images(true_pose(i))));
}

stereo_odometry::StereoTracker StereoTracking::tracker(const TrackerOptions& options) {
  return {RenderedWorld::camera(), RenderedWorld::width, RenderedWorld::height, options, true_pose(0).inverse()};
}

std::vector<FrameResult> StereoTracking::track(const TrackerOptions& options) const {
  stereo_odometry::StereoTracker odometry = tracker(options);
  std::vector<FrameResult> results;
  for (const stereo_odometry::StereoFeatures& features : features_) results.push_back(odometry.track(features));
  return results;
}

void StereoTracking::blank(std::size_t first, std::size_t count) {
  for (std::size_t i = first; i < first + count; ++i) features_[i] = extractor_.extract(RenderedWorld::blank());
}

void StereoTracking::expect_drift_below(const std::vector<FrameResult>& results, std::size_t i, double m, double deg) {
  const Pose truth = true_pose(i - 1).inverse() * true_pose(i);
  const Pose drift = truth.inverse() * (results[i - 1].T_cw * results[i].T_cw.inverse());
  EXPECT_LT(drift.translation().norm(), m) << i;
  EXPECT_LT(degrees(sim::rotation_angle(drift.linear())), deg) << i;
}

void StereoTracking::expect_near_truth(const FrameResult& result, std::size_t i, double m, double deg) {
  const Pose error = result.T_cw * true_pose(i);
  EXPECT_LT(error.translation().norm(), m) << i;
  EXPECT_LT(degrees(sim::rotation_angle(error.linear())), deg) << i;
}

void StereoTracking::expect_follows_the_truth(const TrackerOptions& options) const {
  const std::vector<FrameResult> results = track(options);
  EXPECT_EQ(results[0].status, FrameStatus::initialized);
  EXPECT_TRUE(results[0].is_keyframe);
  EXPECT_TRUE(results[0].T_cw.isApprox(true_pose(0).inverse(), 1e-12)) << "begins at the given pose";
  Replay map(RenderedWorld::camera(), options);
  map.add(results[0], features_[0]);
  std::size_t keyframes = 0;
  for (std::size_t i = 1; i < results.size(); ++i) {
    expect_consistent(results[i], RenderedWorld::camera(), options, map);
    map.add(results[i], features_[i]);
    expect_drift_below(results, i, 0.015, 0.1);
    expect_near_truth(results[i], i, 0.02, 0.15);
    if (results[i].is_keyframe) ++keyframes;
  }
  EXPECT_GE(keyframes, 1U) << "the camera moves enough for another one";
  EXPECT_LE(keyframes, 4U);
}

}  // namespace maxlogdet::test
