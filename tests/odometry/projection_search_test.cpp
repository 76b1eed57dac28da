// SPDX-License-Identifier: MIT
#include "bench/does_it_track/projection_search.hpp"
#include "tests/odometry/made_features.hpp"
#include "tests/odometry/rendered_world.hpp"
#include "tests/support/traced_random.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace maxlogdet::test {
namespace {

using stereo_odometry::Descriptor;
using stereo_odometry::MapPoints;
using stereo_odometry::Prediction;
using stereo_odometry::ProjectionSearch;
using stereo_odometry::StereoFeatures;

constexpr int width = RenderedWorld::width, height = RenderedWorld::height;
const PinholeCamera camera = RenderedWorld::camera();

// Flips this number of bits, from the first on or from the last on.
Descriptor changed(Descriptor descriptor, int bits, bool from_behind = false) {
  for (int i = 0; i < bits; ++i) {
    const int bit = from_behind ? 255 - i : i;
    descriptor[static_cast<std::size_t>(bit / 8)] ^= static_cast<unsigned char>(1 << bit % 8);
  }
  return descriptor;
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
  add_keypoint(features, 100, 100, 1, random_descriptor(random));
  add_keypoint(features, 105, 100, 1, wanted);           // too far away
  add_keypoint(features, 101, 99, 3, wanted);            // its level is too high
  add_keypoint(features, 101, 99, 1, wanted, 101 - 30);  // its disparity differs
  EXPECT_EQ(find(features, prediction_at(100, 100, 1, wanted), 4), ProjectionSearch::none);
  add_keypoint(features, 97, 102, 2, changed(wanted, 40), 97 - 21);
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
        add_keypoint(features, 64 + factor * radius * x, 96 + factor * radius * y, octave,
                     wanted);  // at the corner of four cells
        EXPECT_EQ(find(features, prediction_at(64, 96, octave, wanted), 4) == 0, factor < 1) << octave;
      }
    }
  }
}

TEST(ProjectionSearch, finds_keypoints_all_over_the_image) {
  TracedRandom random;
  StereoFeatures features;
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < 300; ++i) {
    descriptors.push_back(random_descriptor(random));
    add_keypoint(features, random.uniform(0, width - 0.01), random.uniform(0, height - 0.01), 0, descriptors.back());
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
  add_keypoint(features, 100, 100, 0, wanted);
  add_keypoint(features, 101, 100, 0, changed(wanted, 30));
  ProjectionSearch search = search_of(features);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 0);
  search.take(0);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 1);
  search.take(1);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), ProjectionSearch::none);
  search.give_back(1);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 1);
  search.start(features);
  EXPECT_EQ(search.find(prediction_at(100, 100, 0, wanted), 4), 0) << "start() discards the old keypoints";
}

TEST(ProjectionSearch, takes_nothing_unlike_or_doubtful) {
  Random random;
  const Descriptor wanted = random_descriptor(random);
  // Distance of the best keypoint, distance and level of its rival, and whether the best one is accepted.
  const struct {
    int best, rival, rival_octave;
    bool is_found;
  } cases[] = {{100, 256, 0, true}, {101, 256, 0, false}, {40, 50, 0, true},
               {40, 49, 0, false},  {40, 41, 1, true},    {0, 0, 0, true}};
  for (const auto& one : cases) {
    for (const bool rival_is_first : {false, true}) {
      StereoFeatures features;
      const auto add_rival = [&] {
        add_keypoint(features, 101, 100, one.rival_octave, changed(wanted, one.rival, true));
      };
      if (rival_is_first) add_rival();
      add_keypoint(features, 100, 100, 0, changed(wanted, one.best));
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
  add_keypoint(features, 100, 100, 0, seen);
  add_keypoint(features, 200, 100, 0, other);
  ProjectionSearch search = search_of(features);
  const Prediction far = prediction_at(101, 100, 0, changed(seen, 60)),
                   nearer = prediction_at(99, 100, 0, changed(seen, 20)),
                   nearest = prediction_at(100, 101, 0, changed(seen, 10)), alone = prediction_at(200, 100, 0, other);
  using Found = std::vector<std::int64_t>;
  Found found(1, 7);  // of an earlier call
  const auto find_all = [&](const std::vector<Prediction>& predictions) {
    search.find_all(predictions, 4, found);
    return found;
  };
  EXPECT_EQ(find_all({far, nearer, alone, nearest}), Found({-1, -1, 1, 0}));
  EXPECT_EQ(find_all({nearest, alone, nearer, far}), Found({0, 1, -1, -1}));
  EXPECT_EQ(find_all({nearer, nearer}), Found({0, -1})) << "the first of two equal predictions";
  EXPECT_EQ(find_all({}), Found());
}

MapPoints random_map(Random& random, const Eigen::Vector3d& center) {
  MapPoints map;
  for (int i = 0; i < 4000; ++i) {
    stereo_odometry::MapPoint point;
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
  return map;
}

// `found` is map point i of pixel (u, v) and this octave, p in the camera's frame.
void expect_prediction(const Prediction& found, const MapPoints& map, std::size_t i, const Eigen::Vector3d& p, double u,
                       double v, double octave) {
  ASSERT_EQ(found.point, i);
  EXPECT_EQ(found.descriptor, map.points[i].descriptor);
  EXPECT_NEAR(std::hypot(found.u - u, found.v - v), 0, 1e-9);
  EXPECT_NEAR(found.u_right, camera.fx * (p.x() - camera.bf / camera.fx) / p.z() + camera.cx, 1e-9);
  EXPECT_EQ(found.octave, std::min(7, std::max(0, static_cast<int>(std::floor(octave + 0.5)))));
}

TEST(PointsInView, are_those_in_front_in_the_image_and_seen_from_nearby_before) {
  TracedRandom random;
  const sim::Pose T_cw = RenderedWorld::T_wc(9).inverse();
  const Eigen::Vector3d center = T_cw.inverse() * Eigen::Vector3d::Zero();
  const MapPoints map = random_map(random, center);
  std::vector<Prediction> predictions(3);  // of an earlier call
  find_points_in_view(map, 1, camera, width, height, T_cw, predictions);
  std::size_t next = 0, behind = 0, outside = 0, turned = 0, too_near_or_far = 0, too_old = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    const stereo_odometry::MapPoint& point = map.points[i];
    const Eigen::Vector3d p = T_cw * map.positions[i];
    const double u = camera.fx * p.x() / p.z() + camera.cx, v = camera.fy * p.y() / p.z() + camera.cy;
    const Eigen::Vector3d ray = map.positions[i] - center;
    const double angle = std::atan2(ray.cross(point.direction).norm(), ray.dot(point.direction));
    // One octave more for each factor of 1.2 in distance.
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
      ASSERT_NO_FATAL_FAILURE(expect_prediction(predictions[next++], map, i, p, u, v, octave));
    }
  }
  EXPECT_EQ(next, predictions.size());
  for (const std::size_t count : {next, behind, outside, turned, too_near_or_far}) EXPECT_GT(count, 50U);
  EXPECT_GT(too_old, 5U);
}

}  // namespace
}  // namespace maxlogdet::test
