// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/mapped_world.hpp"

#include "bench/world/angles.hpp"
#include "tests/bench/small_worlds.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::MappedWorld;
using sim::Match;
using sim::Pose;
using sim::Trajectory;
using sim::WorldOptions;

Eigen::Vector2d project(const PinholeCamera& camera, const Eigen::Vector3d& p) {
  return {camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy};
}

// Where a point of the world is seen, px, and how far.
struct Sight {
  Eigen::Vector2d pixel;
  double depth;
};

Sight sight_of(const MappedWorld& world, const Frame& frame, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p_c = world.true_T_cw() * point;
  return {project(frame.camera, p_c), p_c.z()};
}

bool is_in_view(const Sight& sight, const Frame& frame) {
  const double u = sight.pixel.x(), v = sight.pixel.y();
  return sight.depth >= 0.5 && u >= 16 && u <= frame.width - 16 && v >= 16 && v <= frame.height - 16;
}

const MappedWorld::Landmark& landmark_of(const MappedWorld& world, const Match& match) {
  return world.landmarks()[static_cast<std::size_t>(match.map_point_id)];
}

// The error of a match against the projection of its true landmark, px.
Eigen::Vector2d error_of(const MappedWorld& world, const Frame& frame, const Match& match) {
  return Eigen::Vector2d(match.u, match.v) - sight_of(world, frame, landmark_of(world, match).position).pixel;
}

TEST(MappedWorld, follows_the_trajectory_and_leaves_the_prior_alone) {
  const Trajectory trajectory = sim::analytic_trajectory(2);
  MappedWorld world(trajectory, sim::euroc_rig(), small_world(), 1);
  Frame frame;
  frame.T_cw_prior[3] = 17;
  for (const auto& pose : trajectory.poses) {
    ASSERT_TRUE(world.next(frame));
    const Pose T_wc = pose.T_wb * sim::euroc_rig().T_bc;
    EXPECT_LT((world.true_T_cw().matrix() - T_wc.inverse().matrix()).norm(), 1e-12);
    EXPECT_EQ(frame.width, 752);
    EXPECT_EQ(frame.T_cw_prior[3], 17);
  }
  EXPECT_FALSE(world.next(frame));
}

TEST(MappedWorld, without_errors_every_point_projects_to_its_pixel) {
  for_every_frame(sim::analytic_trajectory(10), perfect_world(), 1, [&](const MappedWorld& world, const Frame& frame) {
    EXPECT_GE(frame.matches.size(), 50U);
    for (const Match& match : frame.matches) {
      const Sight sight = sight_of(world, frame, Eigen::Map<const Eigen::Vector3d>(match.point));
      ASSERT_GT(sight.depth, 0.4);
      ASSERT_LT((sight.pixel - Eigen::Vector2d(match.u, match.v)).norm(), 1e-9);
      ASSERT_TRUE(match.u > 0 && match.u < frame.width && match.v > 0 && match.v < frame.height);
      ASSERT_FALSE(match.is_stereo());
    }
  });
}

TEST(MappedWorld, pixel_noise_grows_with_the_octave_as_its_weight_says) {
  WorldOptions options = small_world();  // errors of the map do not matter: the truth is the reference
  options.outlier_rate = 0;
  options.pixel_sigma = 1.5;
  std::vector<double> squares(8, 0), counts(8, 0);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for_every_match(10, options, [&](const MappedWorld& world, const Frame& frame, const Match& match) {
    const auto octave = static_cast<std::size_t>(match.octave);
    ASSERT_LT(octave, 8U);
    EXPECT_NEAR(match.inv_sigma2, std::pow(1.2, -2.0 * match.octave), 1e-12);
    const Eigen::Vector2d error = error_of(world, frame, match) / (1.5 * std::pow(1.2, match.octave));
    sum += error;
    squares[octave] += error.squaredNorm();
    counts[octave] += 2;
  });
  double count = 0;
  for (std::size_t octave = 0; octave < 8; ++octave) {
    ASSERT_GT(counts[octave], 100) << octave;
    EXPECT_NEAR(squares[octave] / counts[octave], 1, 5 * std::sqrt(2 / counts[octave])) << octave;
    count += counts[octave] / 2;
  }
  EXPECT_LT(sum.norm(), 6 * std::sqrt(2 * count));
}

TEST(MappedWorld, outliers_have_the_configured_rate_and_errors_of_5_to_40_px) {
  WorldOptions options = perfect_world();
  options.outlier_rate = 0.2;
  double matches = 0, outliers = 0, distance = 0;
  Eigen::Vector2d directions = Eigen::Vector2d::Zero();
  for_every_match(10, options, [&](const MappedWorld& world, const Frame& frame, const Match& match) {
    ++matches;
    const Eigen::Vector2d error = error_of(world, frame, match);
    if (error.norm() < 1e-6) return;
    ++outliers;
    distance += error.norm();
    directions += error.normalized();
    ASSERT_GT(error.norm(), 5 - 1e-6);
    ASSERT_LT(error.norm(), 40 + 1e-6);
  });
  EXPECT_NEAR(outliers, 0.2 * matches, 5 * std::sqrt(0.16 * matches));
  EXPECT_NEAR(distance / outliers, 22.5, 5 * 35 / std::sqrt(12 * outliers));
  EXPECT_LT(directions.norm(), 5 * std::sqrt(outliers));
}

TEST(MappedWorld, keyframes_are_made_as_the_camera_moves_and_never_within_5_frames) {
  const Trajectory trajectory = sim::analytic_trajectory(20);
  std::size_t keyframes = 0, at = 0, frame_number = 0;
  Pose T_keyframe = Pose::Identity();
  for_every_frame(trajectory, small_world(), 1, [&](const MappedWorld& world, const Frame&) {
    if (world.keyframes() != keyframes) {
      ASSERT_EQ(world.keyframes(), keyframes + 1);
      if (keyframes > 0) {
        ASSERT_GE(frame_number - at, 5U);
      }
      keyframes = world.keyframes();
      at = frame_number;
      T_keyframe = world.true_T_cw();
    } else if (frame_number - at >= 5) {
      const Pose motion = world.true_T_cw() * T_keyframe.inverse();
      ASSERT_LE(motion.translation().norm(), 0.25);
      ASSERT_LE(sim::rotation_angle(motion.rotation()), 10 * sim::radians);
    }
    ++frame_number;
  });
  EXPECT_GT(keyframes, 20U);

  Trajectory still = trajectory;
  for (auto& pose : still.poses) pose.T_wb = trajectory.poses[0].T_wb;
  for_every_frame(still, small_world(), 1, [&](const MappedWorld& world, const Frame&) {
    EXPECT_EQ(world.keyframes(), 1U) << "nothing new is in view";
  });
}

TEST(MappedWorld, forgets_a_landmark_after_10_keyframes_out_of_view_and_no_sooner) {
  const Trajectory trajectory = sim::analytic_trajectory(60);
  WorldOptions options = perfect_world();
  options.landmarks = 1500;
  std::vector<std::uint32_t> batches(options.landmarks, 0), seen(options.landmarks, 0);
  std::uint32_t keyframes = 0;
  int forgotten = 0, remembered = 0;
  for_every_frame(trajectory, options, 1, [&](const MappedWorld& world, const Frame& frame) {
    for (std::size_t i = 0; i < options.landmarks; ++i) {
      const auto& landmark = world.landmarks()[i];
      const bool is_seen = is_in_view(sight_of(world, frame, landmark.position), frame);
      const bool is_late = is_seen && keyframes - seen[i] > 10;
      if (batches[i] != 0) {
        ASSERT_EQ(landmark.batch != batches[i], is_late) << i;
        ++(is_late ? forgotten : remembered);
      }
      if (is_seen) seen[i] = static_cast<std::uint32_t>(world.keyframes());
      batches[i] = landmark.batch;
    }
    keyframes = static_cast<std::uint32_t>(world.keyframes());
  });
  EXPECT_GT(forgotten, 50);
  EXPECT_GT(remembered, 50);
}

}  // namespace
}  // namespace maxlogdet::test
