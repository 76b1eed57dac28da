// SPDX-License-Identifier: MIT
#include "examples/stereo_odometry/projection_search.hpp"
#include "tests/tracker/rendered_world.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

using sim::Match;
using sim::Pose;
using stereo_odometry::Descriptor;
using stereo_odometry::LocalMap;
using stereo_odometry::MapOptions;
using stereo_odometry::MapPoint;
using stereo_odometry::MapPoints;
using stereo_odometry::Prediction;
using stereo_odometry::ProjectionSearch;
using stereo_odometry::StereoFeatures;

constexpr int width = RenderedWorld::width, height = RenderedWorld::height;
const PinholeCamera camera = RenderedWorld::camera();

Descriptor random_descriptor(Random& random) {
  Descriptor descriptor;
  for (unsigned char& byte : descriptor) byte = static_cast<unsigned char>(random.integer(0, 255));
  return descriptor;
}

// With so many of its bits turned over, from the first or from the last on.
Descriptor changed(Descriptor descriptor, int bits, bool from_behind = false) {
  for (int i = 0; i < bits; ++i) {
    const int bit = from_behind ? 255 - i : i;
    descriptor[static_cast<std::size_t>(bit / 8)] ^= static_cast<unsigned char>(1 << bit % 8);
  }
  return descriptor;
}

void add(StereoFeatures& features, double u, double v, int octave, Descriptor descriptor, double u_right = -1) {
  features.keypoints.emplace_back(static_cast<float>(u), static_cast<float>(v), 31.0F, -1.0F, 0.0F, octave);
  features.u_right.push_back(u_right);
  features.descriptors.push_back(cv::Mat(1, 32, CV_8UC1, descriptor.data()));
}

Prediction prediction_at(double u, double v, int octave, const Descriptor& descriptor) {
  Prediction prediction;
  prediction.descriptor = descriptor;
  prediction.u = u;
  prediction.v = v;
  prediction.u_right = u - 20;
  prediction.octave = octave;
  return prediction;
}

ProjectionSearch search_of(const StereoFeatures& features) {
  ProjectionSearch search(width, height);
  search.start(features);
  return search;
}

std::int64_t find(const StereoFeatures& features, const Prediction& prediction, double radius) {
  return search_of(features).find(prediction, radius);
}

TEST(ProjectionSearch, finds_the_keypoint_most_like_the_point_among_those_that_may_be_it) {
  Random random;
  const Descriptor wanted = random_descriptor(random);
  StereoFeatures features;
  add(features, 100, 100, 1, random_descriptor(random));
  add(features, 105, 100, 1, wanted);           // too far off
  add(features, 101, 99, 3, wanted);            // of too high a level
  add(features, 101, 99, 1, wanted, 101 - 30);  // its disparity is another
  EXPECT_EQ(find(features, prediction_at(100, 100, 1, wanted), 4), ProjectionSearch::none);
  add(features, 97, 102, 2, changed(wanted, 40), 97 - 21);
  EXPECT_EQ(find(features, prediction_at(100, 100, 1, wanted), 4), 4);
  EXPECT_EQ(find(features, prediction_at(100, 100, 1, wanted), 4.5), 1) << "5.4 px at level 1";
}

TEST(ProjectionSearch, searches_as_wide_as_the_level_is_coarse) {
  Random random;
  const Descriptor wanted = random_descriptor(random);
  for (int octave = 0; octave < stereo_odometry::pyramid_levels; ++octave) {
    const double radius = 4 * std::pow(1.2, octave);
    for (const double factor : {0.98, 1.02}) {
      for (const auto& [x, y] : {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)}) {
        StereoFeatures features;
        add(features, 64 + factor * radius * x, 96 + factor * radius * y, octave, wanted);  // at a corner of cells
        EXPECT_EQ(find(features, prediction_at(64, 96, octave, wanted), 4) == 0, factor < 1) << octave;
      }
    }
  }
}

TEST(ProjectionSearch, finds_keypoints_all_over_the_image) {
  Random random;
  SCOPED_TRACE(random.name());
  StereoFeatures features;
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < 300; ++i) {
    descriptors.push_back(random_descriptor(random));
    add(features, random.uniform(0, width - 0.01), random.uniform(0, height - 0.01), 0, descriptors.back());
  }
  for (std::size_t i = 0; i < 300; ++i) {
    const cv::Point2f& pixel = features.keypoints[i].pt;
    const Prediction near = prediction_at(static_cast<double>(pixel.x) + random.uniform(-9, 9),
                                          static_cast<double>(pixel.y) + random.uniform(-9, 9), 0, descriptors[i]);
    EXPECT_EQ(find(features, near, 10), static_cast<std::int64_t>(i));
  }
}

TEST(ProjectionSearch, passes_by_what_is_taken) {
  Random random;
  const Descriptor wanted = random_descriptor(random);
  StereoFeatures features;
  add(features, 100, 100, 0, wanted);
  add(features, 101, 100, 0, changed(wanted, 30));
  ProjectionSearch search = search_of(features);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 0);
  search.take(0);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 1);
  search.take(1);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), ProjectionSearch::none);
  search.give_back(1);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 1);
  search.start(features);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 0) << "begins anew";
}

TEST(ProjectionSearch, takes_nothing_unlike_or_doubtful) {
  Random random;
  const Descriptor wanted = random_descriptor(random);
  // Distance of the best, distance and level of its rival, and whether the best is believed.
  const struct {
    int best, rival, rival_octave;
    bool is_found;
  } cases[] = {{100, 256, 0, true}, {101, 256, 0, false}, {40, 50, 0, true},
               {40, 49, 0, false},  {40, 41, 1, true},    {0, 0, 0, true}};
  for (const auto& one : cases) {
    for (const bool rival_is_first : {false, true}) {
      StereoFeatures features;
      const auto add_rival = [&] { add(features, 101, 100, one.rival_octave, changed(wanted, one.rival, true)); };
      if (rival_is_first) add_rival();
      add(features, 100, 100, 0, changed(wanted, one.best));
      if (!rival_is_first) add_rival();
      const std::int64_t found = find(features, prediction_at(100, 100, 0, wanted), 4);
      const std::int64_t best = rival_is_first && one.best < one.rival ? 1 : 0;
      EXPECT_EQ(found, one.is_found ? best : ProjectionSearch::none) << one.best << ' ' << one.rival;
    }
  }
}

TEST(ProjectionSearch, of_several_points_the_most_like_gets_the_keypoint) {
  Random random;
  const Descriptor seen = random_descriptor(random), other = random_descriptor(random);
  StereoFeatures features;
  add(features, 100, 100, 0, seen);
  add(features, 200, 100, 0, other);
  ProjectionSearch search = search_of(features);
  const Prediction far = prediction_at(101, 100, 0, changed(seen, 60)),
                   nearer = prediction_at(99, 100, 0, changed(seen, 20)),
                   nearest = prediction_at(100, 101, 0, changed(seen, 10)), alone = prediction_at(200, 100, 0, other);
  using Found = std::vector<std::int64_t>;
  Found found(1, 7);  // from before
  const auto find_all = [&](const std::vector<Prediction>& predictions) {
    search.find_all(predictions, 4, found);
    return found;
  };
  EXPECT_EQ(find_all({far, nearer, alone, nearest}), Found({-1, -1, 1, 0}));
  EXPECT_EQ(find_all({nearest, alone, nearer, far}), Found({0, 1, -1, -1}));
  EXPECT_EQ(find_all({nearer, nearer}), Found({0, -1})) << "the first of two that are alike";
  EXPECT_EQ(find_all({}), Found());
}

TEST(PointsInView, are_those_in_front_in_the_image_and_seen_from_nearby_before) {
  Random random;
  SCOPED_TRACE(random.name());
  const Pose T_cw = RenderedWorld::T_wc(9).inverse();
  const Eigen::Vector3d center = T_cw.inverse() * Eigen::Vector3d::Zero();
  MapPoints map;
  for (int i = 0; i < 4000; ++i) {
    MapPoint point;
    point.id = i;
    const Eigen::Vector3d position(random.uniform(-6, 6), random.uniform(-4, 4), random.uniform(-4, 12));
    point.direction = (position - center).normalized();
    const Eigen::Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    point.direction = Eigen::AngleAxisd(random.uniform(0, 2), axis.normalized()) * point.direction;
    point.distance = (position - center).norm() * random.uniform(0.4, 2.5);
    point.octave = random.integer(0, 7);
    point.descriptor = random_descriptor(random);
    map.push_back(point, position);
    map.views.back() = random.integer(0, 9);
  }
  std::vector<Prediction> predictions(3);  // from before
  find_points_in_view(map, 1, camera, width, height, T_cw, predictions);
  std::size_t next = 0, behind = 0, outside = 0, turned = 0, too_near_or_far = 0, too_old = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    const MapPoint& point = map.points[i];
    const Eigen::Vector3d p = T_cw * map.positions[i];
    const double u = camera.fx * p.x() / p.z() + camera.cx, v = camera.fy * p.y() / p.z() + camera.cy;
    const Eigen::Vector3d ray = map.positions[i] - center;
    const double angle = std::atan2(ray.cross(point.direction).norm(), ray.dot(point.direction));
    // An octave up for every 1.2 times nearer.
    const double octave = point.octave + std::log2(point.distance / ray.norm()) / std::log2(1.2);
    if (p.z() <= 0) {
      ++behind;
    } else if (u < 0 || u >= width || v < 0 || v >= height) {
      ++outside;
    } else if (angle > std::acos(0.5)) {
      ++turned;
    } else if (octave < -1 || octave > 8) {
      ++too_near_or_far;
    } else if (map.views[i] < 1) {
      ++too_old;
    } else {
      ASSERT_LT(next, predictions.size());
      const Prediction& found = predictions[next++];
      ASSERT_EQ(found.point, i);
      EXPECT_EQ(found.descriptor, point.descriptor);
      EXPECT_NEAR(found.u, u, 1e-9);
      EXPECT_NEAR(found.v, v, 1e-9);
      EXPECT_NEAR(found.u_right, camera.fx * (p.x() - camera.bf / camera.fx) / p.z() + camera.cx, 1e-9);
      EXPECT_EQ(found.octave, std::min(7, std::max(0, static_cast<int>(std::floor(octave + 0.5)))));
    }
  }
  EXPECT_EQ(next, predictions.size());
  for (const std::size_t count : {next, behind, outside, turned, too_near_or_far}) EXPECT_GT(count, 50U);
  EXPECT_GT(too_old, 5U);
}

// ---- LocalMap

// Column and row left, column right.
Eigen::Vector3d project(const Pose& T_cw, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = T_cw * point;
  const double u = camera.fx * p.x() / p.z() + camera.cx;
  return {u, camera.fy * p.y() / p.z() + camera.cy, u - camera.bf / p.z()};
}

// H_p of the three by central differences.
Eigen::Matrix3d jacobian(const Pose& T_cw, const Eigen::Vector3d& point) {
  Eigen::Matrix3d H;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(i);
    H.col(i) = (project(T_cw, point + step) - project(T_cw, point - step)) / 2e-5;
  }
  return H;
}

// Normal, up to the twelfth moment or so: a sum of uniform numbers.
double normal(Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform(0, 1);
  return sum;
}

Eigen::Vector3d random_landmark(Random& random) {
  const double depth = random.uniform(2, 6);
  return {random.uniform(-0.5, 0.5) * depth, random.uniform(-0.4, 0.4) * depth, depth};
}

// What a camera sees of these, with noise of aligned_sigma where `random` is given.
StereoFeatures features_of(const Pose& T_cw, const std::vector<Eigen::Vector3d>& landmarks, Random* random = nullptr) {
  StereoFeatures features;
  const double sigma = random == nullptr ? 0 : stereo_odometry::aligned_sigma;
  const auto noise = [&] { return random == nullptr ? 0 : sigma * normal(*random); };
  for (const Eigen::Vector3d& landmark : landmarks) {
    const Eigen::Vector3d z = project(T_cw, landmark);
    add(features, z[0] + noise(), z[1] + noise(), 0, Descriptor{}, z[2] + noise());
  }
  return features;
}

// points[i] is that of keypoint i.
void add_keyframe(LocalMap& map, const Pose& T_cw, const StereoFeatures& features,
                  const std::vector<std::uint32_t>& points) {
  std::vector<Match> matches;
  for (std::size_t i = 0; i < points.size(); ++i) matches.push_back(match_of(map.points(), points[i], features, i));
  map.add_keyframe(T_cw, features, matches, points);
}

// All points of the map.
std::vector<std::uint32_t> all_points(const LocalMap& map) {
  std::vector<std::uint32_t> all(map.points().size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

TEST(LocalMap, makes_points_where_stereo_has_them_as_uncertain_as_stereo_is) {
  Random random;
  SCOPED_TRACE(random.name());
  const Pose T_cw = RenderedWorld::T_wc(5).inverse();
  StereoFeatures features;
  std::vector<std::size_t> stereo;
  std::vector<Descriptor> descriptors;
  for (std::size_t i = 0; i < 200; ++i) {
    const double u = random.uniform(40, 440);
    const bool is_stereo = random.chance(0.7);
    descriptors.push_back(random_descriptor(random));
    add(features, u, random.uniform(0, 320), random.integer(0, 7), descriptors.back(),
        is_stereo ? u - random.uniform(3, 40) : -1);
    if (is_stereo) stereo.push_back(i);
  }
  LocalMap map(camera, MapOptions());
  EXPECT_TRUE(map.is_empty());
  map.add_keyframe(T_cw, features, {}, {});
  EXPECT_FALSE(map.is_empty());
  ASSERT_EQ(map.points().size(), stereo.size()) << "one for each keypoint with a stereo match";
  const Matches arrays = map.points().arrays();
  ASSERT_EQ(arrays.size, stereo.size());
  for (std::size_t p = 0; p < stereo.size(); ++p) {
    const MapPoint& point = map.points().points[p];
    const Eigen::Vector3d position = map.points().positions[p];
    const Eigen::Matrix3d covariance = map.points().covariances[p];
    const std::size_t i = stereo[p];
    const cv::Point2d pixel = features.keypoints[i].pt;
    const Eigen::Vector3d z(pixel.x, pixel.y, features.u_right[i]);
    EXPECT_LT((project(T_cw, position) - z).norm(), 1e-6);
    EXPECT_GT((T_cw * position).z(), 0);
    const Eigen::Matrix3d H = jacobian(T_cw, position);
    const Eigen::Matrix3d expected = (H.transpose() * H / (0.5 * 0.5)).inverse();
    EXPECT_LT((covariance - expected).norm(), 1e-4 * expected.norm());
    EXPECT_EQ(point.descriptor, descriptors[i]);
    EXPECT_EQ(point.octave, features.keypoints[i].octave);
    EXPECT_EQ(point.pixel, features.keypoints[i].pt);
    const Eigen::Vector3d ray = position - T_cw.inverse().translation();
    EXPECT_NEAR(point.distance, ray.norm(), 1e-9);
    EXPECT_LT((point.direction * point.distance - ray).norm(), 1e-9);
    EXPECT_TRUE(point.observations.back().match.is_stereo());

    const double* const read = static_cast<const double*>(arrays.points.data()) + 3 * p;
    EXPECT_TRUE(std::equal(read, read + 3, position.data())) << "as the library reads";
    EXPECT_TRUE(std::equal(arrays.map_covariances + 9 * p, arrays.map_covariances + 9 * p + 9, covariance.data()));
    EXPECT_EQ(arrays.has_third[p], 1);
  }
}

struct Spread {
  double squared_error = 0;  // of positions, mean, m^2
  double variance = 0;       // that the covariances tell, mean, m^2
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
  Random random;
  SCOPED_TRACE(random.name());
  std::vector<Eigen::Vector3d> landmarks;
  for (int i = 0; i < 400; ++i) landmarks.push_back(random_landmark(random));
  LocalMap map(camera, MapOptions());
  Spread before;
  std::vector<double> traces(landmarks.size(), HUGE_VAL);
  for (std::size_t view = 0; view < 4; ++view) {
    const Pose T_cw = RenderedWorld::T_wc(3 * view).inverse();
    const StereoFeatures features = features_of(T_cw, landmarks, &random);
    add_keyframe(map, T_cw, features, all_points(map));
    ASSERT_EQ(map.points().size(), landmarks.size()) << "no new point where there is one";
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      ASSERT_EQ(map.points().points[i].observations.size(), view + 1);
      ASSERT_EQ(map.points().arrays().weights[i], static_cast<double>(view + 1) / static_cast<double>(view + 3));
      EXPECT_LT(map.points().covariances[i].trace(), traces[i]) << i;
      traces[i] = map.points().covariances[i].trace();
    }
    const Spread now = spread_of(map.points(), landmarks);
    EXPECT_NEAR(now.squared_error_in_deviations, 3, 0.6) << "of 3 degrees of freedom";
    if (view == 0) {
      before = now;
      continue;
    }
    const double share = 1 / static_cast<double>(view + 1);
    EXPECT_LT(now.squared_error, 1.4 * share * before.squared_error) << "noise averages out";
    EXPECT_LT(now.variance, 1.2 * share * before.variance);
  }
}

TEST(LocalMap, consists_of_the_last_keyframes) {
  Random random;
  SCOPED_TRACE(random.name());
  MapOptions options;
  options.keyframes = 3;
  LocalMap map(camera, options);
  const Pose T_cw = Pose::Identity();
  std::vector<std::vector<std::int64_t>> of_keyframes;  // ids
  for (int i = 0; i < 6; ++i) {
    // 10 new points and, from the second on, 5 of the keyframe before, which are the last in the map.
    std::vector<std::uint32_t> known = all_points(map);
    known.erase(known.begin(), known.end() - std::min<std::ptrdiff_t>(5, static_cast<std::ptrdiff_t>(known.size())));
    std::vector<Eigen::Vector3d> landmarks;
    std::vector<std::int64_t> known_ids;
    for (const std::uint32_t point : known) {
      landmarks.push_back(map.points().positions[point]);
      known_ids.push_back(map.points().points[point].id);
    }
    for (int n = 0; n < 10; ++n) landmarks.push_back(random_landmark(random));
    add_keyframe(map, T_cw, features_of(T_cw, landmarks), known);

    of_keyframes.emplace_back();
    std::vector<std::int64_t> ids;
    for (std::size_t p = 0; p < map.points().size(); ++p) {
      ids.push_back(map.points().points[p].id);
      if (map.points().views[p] == i) of_keyframes.back().push_back(ids.back());
    }
    ASSERT_EQ(of_keyframes.back().size(), landmarks.size());
    EXPECT_TRUE(std::equal(known_ids.begin(), known_ids.end(), of_keyframes.back().begin()));
    std::set<std::int64_t> expected;
    for (std::size_t k = of_keyframes.size() > 3 ? of_keyframes.size() - 3 : 0; k < of_keyframes.size(); ++k) {
      expected.insert(of_keyframes[k].begin(), of_keyframes[k].end());
    }
    EXPECT_EQ(ids, std::vector<std::int64_t>(expected.begin(), expected.end())) << "in order of id, no doubles";
    ASSERT_EQ(map.views().size(), std::min<std::size_t>(of_keyframes.size(), 3));
    EXPECT_EQ(map.views().back().number, i);
    EXPECT_EQ(map.first_of_last(0), i);
    EXPECT_EQ(map.first_of_last(1), i);
    EXPECT_EQ(map.first_of_last(2), std::max(0, i - 1));
    EXPECT_EQ(map.first_of_last(100), std::max(0, i - 2)) << "the oldest there is";
  }
  map.clear();
  EXPECT_TRUE(map.is_empty());
  EXPECT_EQ(map.points().arrays().size, 0U);
}

TEST(LocalMap, points_keep_as_many_observations_as_there_are_keyframes) {
  Random random;
  MapOptions options;
  options.keyframes = 2;
  LocalMap map(camera, options);
  const std::vector<Eigen::Vector3d> landmarks = {random_landmark(random)};
  for (std::size_t view = 0; view < 5; ++view) {
    const Pose T_cw = RenderedWorld::T_wc(view).inverse();
    const StereoFeatures features = features_of(T_cw, landmarks);
    add_keyframe(map, T_cw, features, all_points(map));
    const auto& observations = map.points().points.at(0).observations;
    ASSERT_EQ(observations.size(), std::min<std::size_t>(view + 1, 2));
    EXPECT_EQ(observations.front().view, 0) << "the first one";
    EXPECT_EQ(observations.back().view, view) << "and the last ones";
  }
  for (std::size_t view = 0; view < 5; ++view)
    EXPECT_TRUE(map.pose_of(static_cast<std::int64_t>(view)).isApprox(RenderedWorld::T_wc(view).inverse(), 0));
}

TEST(LocalMap, keeps_no_image_of_a_keyframe_that_has_left_it_though_its_points_stay) {
  Random random;
  MapOptions options;
  options.keyframes = 2;
  LocalMap map(camera, options);
  const std::vector<Eigen::Vector3d> landmarks = {random_landmark(random)};
  std::vector<cv::Mat> images;
  for (int view = 0; view < 5; ++view) {
    const Pose T_cw = RenderedWorld::T_wc(static_cast<std::size_t>(view)).inverse();
    StereoFeatures features = features_of(T_cw, landmarks);
    images.emplace_back(height, width, CV_8UC1);
    features.pyramid = {images.back()};
    add_keyframe(map, T_cw, features, all_points(map));
  }
  for (std::size_t view = 0; view < images.size(); ++view) {
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
