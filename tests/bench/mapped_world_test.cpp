// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/mapped_world.hpp"

#include "bench/does_the_paper_hold/trajectory_error.hpp"
#include "bench/world/angles.hpp"
#include "bench/world/euroc_camera.hpp"
#include "tests/bench/flight.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::MappedWorld;
using sim::Match;
using sim::Pose;
using sim::WorldOptions;

// Where a point of the world is seen, px, and how far.
struct Sight {
  Eigen::Vector2d pixel;
  double depth;

  Sight(const MappedWorld& world, const Eigen::Vector3d& point) {
    const Eigen::Vector3d p = world.true_T_cw() * point;
    pixel << sim::euroc_camera.fx * p.x() / p.z() + sim::euroc_camera.cx,
        sim::euroc_camera.fy * p.y() / p.z() + sim::euroc_camera.cy;
    depth = p.z();
  }
  bool is_in_view() const {
    return depth >= 0.5 && pixel.x() >= 16 && pixel.x() <= sim::euroc_width - 16 && pixel.y() >= 16 &&
           pixel.y() <= sim::euroc_height - 16;
  }
};

const MappedWorld::Landmark& landmark_of(const MappedWorld& world, const Match& match) {
  return world.landmarks()[static_cast<std::size_t>(match.map_point_id)];
}

// Calls body(match, landmark, error against the projection of the true landmark, its sight) for every match.
template <class Body>
void for_every_match(double seconds, const WorldOptions& options, const Body& body) {
  for_every_frame(flight(seconds), options, 1, [&](const MappedWorld& world, const Frame& frame) {
    for (const Match& match : frame.matches) {
      const auto& landmark = landmark_of(world, match);
      const Sight sight(world, landmark.position);
      body(match, landmark, Eigen::Vector2d(Eigen::Vector2d(match.u, match.v) - sight.pixel), sight);
    }
  });
}

TEST(MappedWorld, without_errors_every_point_projects_to_its_pixel_along_the_trajectory) {
  const sim::Trajectory trajectory = flight(10);
  WorldOptions options = perfect_world();
  options.max_matches = 120;
  std::size_t i = 0, full = 0;
  for_every_frame(trajectory, options, 1, [&](const MappedWorld& world, const Frame& frame) {
    const Pose T_wc = trajectory.poses.at(i++).T_wb * sim::euroc_T_bc();
    EXPECT_LT((world.true_T_cw().matrix() - T_wc.inverse().matrix()).norm(), 1e-9);
    EXPECT_GE(frame.matches.size(), 50U);
    EXPECT_LE(frame.matches.size(), 120U);
    full += frame.matches.size() == 120 ? 1 : 0;
    std::set<std::int64_t> ids;
    for (const Match& match : frame.matches) {
      ids.insert(match.map_point_id);
      const Sight sight(world, Eigen::Vector3d(match.point[0], match.point[1], match.point[2]));
      ASSERT_TRUE(sight.is_in_view());
      // The rotation of EuRoC's camera is given to 12 digits.
      ASSERT_LT((sight.pixel - Eigen::Vector2d(match.u, match.v)).norm(), 1e-8);
      ASSERT_FALSE(match.is_stereo());
    }
    EXPECT_EQ(ids.size(), frame.matches.size());
  });
  EXPECT_EQ(i, trajectory.poses.size());
  EXPECT_GT(full, 0U);
}

// The nearer the landmark, the larger it is in the image.
TEST(MappedWorld, pixel_noise_grows_with_the_octave_and_the_octave_falls_with_distance) {
  WorldOptions options = small_world();  // errors of the map do not matter: the truth is the reference
  options.outlier_rate = 0;
  options.pixel_sigma = 1.5;
  std::vector<double> squares(8, 0), counts(8, 0);
  for_every_match(10, options, [&](const Match& match, const auto& landmark, const Eigen::Vector2d& error, auto sight) {
    const double octave = landmark.octave + std::log(landmark.reference_depth / sight.depth) / std::log(1.2);
    ASSERT_NEAR(match.octave, std::clamp(octave, 0.0, 7.0), 0.5 + 1e-9);
    EXPECT_NEAR(match.inv_sigma2, std::pow(1.2, -2.0 * match.octave), 1e-12);
    const auto place = static_cast<std::size_t>(match.octave);
    squares[place] += (error / (1.5 * std::pow(1.2, match.octave))).squaredNorm();
    counts[place] += 2;
  });
  for (std::size_t octave = 0; octave < 8; ++octave) {
    ASSERT_GT(counts[octave], 100) << octave;
    EXPECT_NEAR(squares[octave] / counts[octave], 1, 5 * std::sqrt(2 / counts[octave])) << octave;
  }
}

TEST(MappedWorld, outliers_have_the_configured_rate_and_errors_of_5_to_40_px) {
  WorldOptions options = perfect_world();
  options.outlier_rate = 0.2;
  double matches = 0, outliers = 0, distance = 0;
  for_every_match(10, options, [&](const Match&, const auto&, const Eigen::Vector2d& error, const Sight&) {
    ++matches;
    if (error.norm() < 1e-6) return;
    ++outliers;
    distance += error.norm();
    ASSERT_NEAR(error.norm(), 22.5, 17.5 + 1e-6);
  });
  EXPECT_NEAR(outliers, 0.2 * matches, 5 * std::sqrt(0.16 * matches));
  EXPECT_NEAR(distance / outliers, 22.5, 5 * 35 / std::sqrt(12 * outliers));
}

// The points that a keyframe maps are moved by one similarity: fits it, in the keyframe's frame, to those of the first.
TEST(MappedWorld, errors_of_keyframes_have_the_deviations_of_the_options) {
  WorldOptions options = small_world();
  options.landmarks = 1000;
  options.depth_sigma = options.lateral_sigma = 0;
  Eigen::Array3d squares(0, 0, 0);  // of translation, rotation and scale, over their expectations
  const auto seeds = static_cast<std::uint64_t>(trials(300));
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    for_every_frame(flight(0), options, seed, [&](const MappedWorld& world, const Frame&) {
      Eigen::Matrix3Xd from(3, 0), to(3, 0);
      for (const auto& landmark : world.landmarks()) {
        if (landmark.batch != 1) continue;
        from.conservativeResize(3, from.cols() + 1);
        to.conservativeResize(3, to.cols() + 1);
        from.rightCols<1>() = world.true_T_cw() * landmark.position;
        to.rightCols<1>() = world.true_T_cw() * landmark.mapped;
      }
      ASSERT_GT(from.cols(), 5);
      const sim::Similarity similarity = sim::align_sim3(from, to);
      const Eigen::Matrix3Xd moved = (similarity.scale * similarity.R * from).colwise() + similarity.t;
      EXPECT_LT((moved - to).colwise().norm().maxCoeff(), 1e-9);
      const Pose shift = Eigen::Translation3d(similarity.t) * Eigen::Quaterniond(similarity.R);
      const sim::Vector6 xi = sim::log_se3(shift);
      squares +=
          Eigen::Array3d(xi.head<3>().squaredNorm() / (3 * std::pow(options.batch_translation, 2)),
                         xi.tail<3>().squaredNorm() / (3 * std::pow(options.batch_rotation_deg * sim::radians, 2)),
                         std::pow((similarity.scale - 1) / options.batch_scale, 2));
    });
  }
  const auto n = static_cast<double>(seeds);
  for (const double square : squares) EXPECT_NEAR(square / n, 1, 5 * std::sqrt(2 / n));
}

}  // namespace
}  // namespace maxlogdet::test
