// SPDX-License-Identifier: MIT
#include "bench/does_it_track/local_map.hpp"
#include "tests/odometry/made_features.hpp"
#include "tests/odometry/rendered_world.hpp"
#include "tests/support/random_geometry.hpp"
#include "tests/support/traced_random.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

using sim::Pose;
using stereo_odometry::LocalMap;
using stereo_odometry::MapOptions;
using stereo_odometry::MapPoints;
using stereo_odometry::StereoFeatures;

const PinholeCamera camera = RenderedWorld::camera();

// Left column, row, and right column, px.
Eigen::Vector3d project(const Pose& T_cw, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = T_cw * point;
  const double u = camera.fx * p.x() / p.z() + camera.cx;
  return {u, camera.fy * p.y() / p.z() + camera.cy, u - camera.bf / p.z()};
}

// The Jacobian of project() by central differences.
Eigen::Matrix3d jacobian(const Pose& T_cw, const Eigen::Vector3d& point) {
  Eigen::Matrix3d H;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(i);
    H.col(i) = (project(T_cw, point + step) - project(T_cw, point - step)) / 2e-5;
  }
  return H;
}

Eigen::Vector3d random_landmark(Random& random) {
  const double depth = random.uniform(2, 6);
  return {random.uniform(-0.5, 0.5) * depth, random.uniform(-0.4, 0.4) * depth, depth};
}

// The features of the landmarks, with noise of aligned_sigma if `random` is given.
StereoFeatures features_of(const Pose& T_cw, const std::vector<Eigen::Vector3d>& landmarks, Random* random = nullptr) {
  StereoFeatures features;
  const double sigma = random == nullptr ? 0 : stereo_odometry::aligned_sigma;
  const auto noise = [&] { return random == nullptr ? 0 : sigma * normal(*random); };
  for (const Eigen::Vector3d& landmark : landmarks) {
    const Eigen::Vector3d z = project(T_cw, landmark);
    add_keypoint(features, z[0] + noise(), z[1] + noise(), 0, stereo_odometry::Descriptor{}, z[2] + noise());
  }
  return features;
}

// Adds a keyframe; points[i] belongs to keypoint i.
void add_keyframe(LocalMap& map, const Pose& T_cw, const StereoFeatures& features,
                  const std::vector<std::uint32_t>& points) {
  std::vector<sim::Match> matches;
  for (std::size_t i = 0; i < points.size(); ++i) matches.push_back(match_of(map.points(), points[i], features, i));
  map.add_keyframe(T_cw, features, matches, points);
}

std::vector<std::uint32_t> all_points(const LocalMap& map) {
  std::vector<std::uint32_t> all(map.points().size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

// Expects a point where stereo has the keypoint, as uncertain as stereo is.
void expect_stereo_point(const MapPoints& map, std::size_t p, const Pose& T_cw, const StereoFeatures& features,
                         std::size_t keypoint) {
  const stereo_odometry::MapPoint& point = map.points[p];
  const cv::Point2d pixel = features.keypoints[keypoint].pt;
  const Eigen::Vector3d z(pixel.x, pixel.y, features.u_right[keypoint]);
  EXPECT_LT((project(T_cw, map.positions[p]) - z).norm(), 1e-6);
  EXPECT_GT((T_cw * map.positions[p]).z(), 0);
  const Eigen::Matrix3d H = jacobian(T_cw, map.positions[p]);
  const Eigen::Matrix3d expected = (H.transpose() * H / (0.5 * 0.5)).inverse();
  EXPECT_LT((map.covariances[p] - expected).norm(), 1e-4 * expected.norm());
  EXPECT_EQ(point.octave, features.keypoints[keypoint].octave);
  EXPECT_EQ(point.pixel, features.keypoints[keypoint].pt);
  const Eigen::Vector3d ray = map.positions[p] - T_cw.inverse().translation();
  EXPECT_NEAR(point.distance, ray.norm(), 1e-9);
  EXPECT_LT((point.direction * point.distance - ray).norm(), 1e-9);
  EXPECT_TRUE(point.observations.back().match.is_stereo());
}

TEST(LocalMap, makes_points_where_stereo_has_them_as_uncertain_as_stereo_is) {
  TracedRandom random;
  const Pose T_cw = RenderedWorld::T_wc(5).inverse();
  StereoFeatures features;
  std::vector<std::size_t> stereo;
  std::vector<stereo_odometry::Descriptor> descriptors;
  for (std::size_t i = 0; i < 200; ++i) {
    const double u = random.uniform(40, 440);
    const bool is_stereo = random.chance(0.7);
    descriptors.push_back(random_descriptor(random));
    add_keypoint(features, u, random.uniform(0, 320), random.integer(0, 7), descriptors.back(),
                 is_stereo ? u - random.uniform(3, 40) : -1);
    if (is_stereo) stereo.push_back(i);
  }
  LocalMap map(camera, MapOptions());
  EXPECT_TRUE(map.is_empty());
  map.add_keyframe(T_cw, features, {}, {});
  EXPECT_FALSE(map.is_empty());
  const MapPoints& points = map.points();
  ASSERT_EQ(points.size(), stereo.size()) << "one for each keypoint with a stereo match";
  const Matches arrays = points.arrays();
  ASSERT_EQ(arrays.size, stereo.size());
  for (std::size_t p = 0; p < stereo.size(); ++p) {
    expect_stereo_point(points, p, T_cw, features, stereo[p]);
    EXPECT_EQ(points.points[p].descriptor, descriptors[stereo[p]]);
    const double* const read = static_cast<const double*>(arrays.points.data()) + 3 * p;
    const double* const covariance = arrays.map_covariances + 9 * p;
    EXPECT_TRUE(std::equal(read, read + 3, points.positions[p].data())) << "as the library reads";
    EXPECT_TRUE(std::equal(covariance, covariance + 9, points.covariances[p].data()));
    EXPECT_EQ(arrays.has_depth_cue[p], 1);
  }
}

struct Spread {
  double squared_error = 0;  // mean over positions, m^2
  double variance = 0;       // mean of the covariances, m^2
  double squared_error_in_deviations = 0;
};

Spread spread_of(const MapPoints& map, const std::vector<Eigen::Vector3d>& landmarks) {
  Spread spread;
  const auto n = static_cast<double>(map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Eigen::Vector3d error = map.positions[i] - landmarks[i];
    spread.squared_error += error.squaredNorm() / n;
    spread.variance += map.covariances[i].trace() / n;
    spread.squared_error_in_deviations += error.dot(map.covariances[i].inverse() * error) / n;
  }
  return spread;
}

TEST(LocalMap, more_views_bring_points_nearer_to_the_truth_and_the_covariance_knows) {
  TracedRandom random;
  std::vector<Eigen::Vector3d> landmarks;
  for (int i = 0; i < 400; ++i) landmarks.push_back(random_landmark(random));
  LocalMap map(camera, MapOptions());
  Spread before;
  std::vector<double> traces(landmarks.size(), HUGE_VAL);
  for (std::size_t view = 0; view < 4; ++view) {
    const Pose T_cw = RenderedWorld::T_wc(3 * view).inverse();
    const StereoFeatures features = features_of(T_cw, landmarks, &random);
    add_keyframe(map, T_cw, features, all_points(map));
    ASSERT_EQ(map.points().size(), landmarks.size()) << "keypoints with a point get no new one";
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      ASSERT_EQ(map.points().points[i].observations.size(), view + 1);
      ASSERT_EQ(map.points().arrays().weights[i], static_cast<double>(view + 1) / static_cast<double>(view + 3));
      EXPECT_LT(map.points().covariances[i].trace(), traces[i]) << i;
      traces[i] = map.points().covariances[i].trace();
    }
    const Spread now = spread_of(map.points(), landmarks);
    EXPECT_NEAR(now.squared_error_in_deviations, 3, 0.6) << "3 degrees of freedom";
    if (view == 0) {
      before = now;
      continue;
    }
    const double share = 1 / static_cast<double>(view + 1);
    EXPECT_LT(now.squared_error, 1.4 * share * before.squared_error) << "noise averages out";
    EXPECT_LT(now.variance, 1.2 * share * before.variance);
  }
}

using Ids = std::vector<std::int64_t>;

// Adds a keyframe with 10 new points and, from the second one on, the last 5 points of the map. Returns its points.
Ids add_overlapping_keyframe(LocalMap& map, std::int64_t number, Random& random) {
  const Pose T_cw = Pose::Identity();
  std::vector<std::uint32_t> known = all_points(map);
  known.erase(known.begin(), known.end() - std::min<std::ptrdiff_t>(5, static_cast<std::ptrdiff_t>(known.size())));
  std::vector<Eigen::Vector3d> landmarks;
  Ids known_ids;
  for (const std::uint32_t point : known) {
    landmarks.push_back(map.points().positions[point]);
    known_ids.push_back(map.points().points[point].id);
  }
  for (int n = 0; n < 10; ++n) landmarks.push_back(random_landmark(random));
  add_keyframe(map, T_cw, features_of(T_cw, landmarks), known);
  Ids seen;
  for (std::size_t p = 0; p < map.points().size(); ++p) {
    if (map.points().views[p] == number) seen.push_back(map.points().points[p].id);
  }
  EXPECT_EQ(seen.size(), landmarks.size());
  EXPECT_TRUE(seen.size() >= known_ids.size() && std::equal(known_ids.begin(), known_ids.end(), seen.begin()));
  return seen;
}

TEST(LocalMap, consists_of_the_last_keyframes) {
  TracedRandom random;
  MapOptions options;
  options.keyframes = 3;
  LocalMap map(camera, options);
  std::vector<Ids> of_keyframes;
  for (int i = 0; i < 6; ++i) {
    of_keyframes.push_back(add_overlapping_keyframe(map, i, random));
    Ids ids;
    for (const stereo_odometry::MapPoint& point : map.points().points) ids.push_back(point.id);
    std::set<std::int64_t> expected;
    for (std::size_t k = of_keyframes.size() > 3 ? of_keyframes.size() - 3 : 0; k < of_keyframes.size(); ++k) {
      expected.insert(of_keyframes[k].begin(), of_keyframes[k].end());
    }
    EXPECT_EQ(ids, Ids(expected.begin(), expected.end())) << "in order of id, without duplicates";
    ASSERT_EQ(map.views().size(), std::min<std::size_t>(of_keyframes.size(), 3));
    EXPECT_EQ(map.views().back().number, i);
    EXPECT_EQ(map.first_of_last(0), i);
    EXPECT_EQ(map.first_of_last(1), i);
    EXPECT_EQ(map.first_of_last(2), std::max(0, i - 1));
    EXPECT_EQ(map.first_of_last(100), std::max(0, i - 2)) << "the oldest keyframe";
  }
  map.clear();
  EXPECT_TRUE(map.is_empty());
  EXPECT_EQ(map.points().arrays().size, 0U);
}

TEST(LocalMap, keeps_as_many_observations_of_a_point_as_there_are_keyframes_and_images_of_these_alone) {
  Random random;
  MapOptions options;
  options.keyframes = 2;
  LocalMap map(camera, options);
  const std::vector<Eigen::Vector3d> landmarks = {random_landmark(random)};
  std::vector<cv::Mat> images;
  for (std::size_t view = 0; view < 5; ++view) {
    const Pose T_cw = RenderedWorld::T_wc(view).inverse();
    StereoFeatures features = features_of(T_cw, landmarks);
    images.emplace_back(RenderedWorld::height, RenderedWorld::width, CV_8UC1);
    features.pyramid = {images.back()};
    add_keyframe(map, T_cw, features, all_points(map));
    const auto& observations = map.points().points.at(0).observations;
    ASSERT_EQ(observations.size(), std::min<std::size_t>(view + 1, 2));
    EXPECT_EQ(observations.front().view, 0) << "the first observation";
    EXPECT_EQ(observations.back().view, view) << "and the last observations";
  }
  for (std::size_t view = 0; view < images.size(); ++view) {
    EXPECT_TRUE(map.pose_of(static_cast<std::int64_t>(view)).isApprox(RenderedWorld::T_wc(view).inverse(), 0));
    EXPECT_EQ(images[view].u->refcount, view < 3 ? 1 : 2) << view;
  }
}

TEST(LocalMap, needs_a_keyframe_when_the_camera_has_moved_or_turned) {
  LocalMap map(camera, MapOptions());
  const Pose T_cw = RenderedWorld::T_wc(4).inverse();
  std::vector<Eigen::Vector3d> landmarks;
  for (const double depth : {2.0, 4.0, 5.0, 10.0, 20.0})
    landmarks.push_back(T_cw.inverse() * Eigen::Vector3d(0.1, 0.1, depth));
  map.add_keyframe(T_cw, features_of(T_cw, landmarks), {}, {});
  EXPECT_FALSE(map.needs_keyframe(T_cw));
  for (const double factor : {0.99, 1.01}) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
      EXPECT_EQ(map.needs_keyframe(Eigen::Translation3d(-factor * 0.07 * 5 * unit) * T_cw), factor > 1)
          << "0.07 of the median depth, 5 m";
      EXPECT_EQ(map.needs_keyframe(Eigen::AngleAxisd(factor * 0.1, unit) * T_cw), factor > 1) << "0.1 rad";
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
