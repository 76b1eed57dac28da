// SPDX-License-Identifier: MIT
#include "experiments/pose_tracker.hpp"

#include "tests/sim/small_worlds.hpp"
#include "tests/sim/tracked_selectors.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::MappedWorld;
using sim::Pose;
using sim::PoseTracker;
using sim::SelectorKind;
using sim::SelectorSettings;
using sim::TrackedFrame;
using sim::Trajectory;
using sim::WorldOptions;

constexpr std::size_t max_matches = 250;

double distance_between(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

// Calls body(world, frame, tracked) for every frame of a tracker that begins at the truth.
template <class Body>
void track(const Trajectory& trajectory, const WorldOptions& options, PoseTracker& tracker, const Body& body) {
  const sim::Rig rig = sim::forward_rig();
  MappedWorld world(trajectory, rig, options, 1);
  tracker.start((trajectory.poses.front().T_wb * rig.T_bc).inverse());
  Frame frame;
  while (world.next(frame)) {
    const TrackedFrame tracked = tracker.track(frame);
    body(world, frame, tracked);
  }
}

TEST(PoseTracker, is_exact_in_a_perfect_world_whatever_it_selects) {
  const Trajectory trajectory = sim::analytic_trajectory(3);
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    PoseTracker tracker(settings_of(kind), {});
    track(trajectory, perfect_world(max_matches), tracker,
          [&](const MappedWorld& world, const Frame& frame, const auto& tracked) {
            ASSERT_TRUE(tracked.is_tracked);
            ASSERT_LT(distance_between(tracked.T_cw, world.true_T_cw()), 1e-6);
            EXPECT_EQ(tracked.inliers.size(), frame.matches.size());
            EXPECT_EQ(tracked.selected.size(), has_budget(kind) ? 40U : frame.matches.size());
            if (rejects_outliers(kind)) {
              EXPECT_GT(tracked.ms_outliers, 0);
              EXPECT_LT(distance_between(sim::pose_of(frame.T_cw_prior), world.true_T_cw()), 1e-6)
                  << "linearised at the pose of all";
            } else {
              EXPECT_EQ(tracked.ms_outliers + tracked.ms_selection, 0);
            }
            EXPECT_GT(tracked.ms_pose, 0);
          });
  }
}

TEST(PoseTracker, predicts_by_constant_velocity) {
  const Trajectory trajectory = sim::analytic_trajectory(1);
  PoseTracker tracker(settings_of(SelectorKind::md), {});
  std::vector<Pose> poses = {(trajectory.poses.front().T_wb * sim::forward_rig().T_bc).inverse()};
  track(trajectory, small_world(max_matches), tracker,
        [&](const MappedWorld&, const Frame&, const TrackedFrame& tracked) {
          poses.push_back(tracked.T_cw);
          const Pose& last = poses[poses.size() - 1];
          const Pose& before = poses[poses.size() - 2];
          EXPECT_LT(distance_between(tracker.predict(), last * before.inverse() * last), 1e-12);
        });
  EXPECT_EQ(poses.size(), 22U);
}

TEST(PoseTracker, follows_its_prediction_without_matches_and_recovers) {
  const Trajectory trajectory = sim::analytic_trajectory(2);
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    const sim::Rig rig = sim::forward_rig();
    MappedWorld world(trajectory, rig, perfect_world(max_matches), 1);
    PoseTracker tracker(settings_of(kind), {});
    tracker.start((trajectory.poses.front().T_wb * rig.T_bc).inverse());
    Frame frame;
    for (int i = 0; world.next(frame); ++i) {
      const bool is_blind = i >= 10 && i < 13;
      if (is_blind) frame.matches.resize(i == 10 ? 0 : PoseTracker::min_inliers - 1);
      const Pose prediction = tracker.predict();
      const TrackedFrame tracked = tracker.track(frame);
      EXPECT_EQ(tracked.is_tracked, !is_blind) << i;
      if (is_blind) {
        EXPECT_LT(distance_between(tracked.T_cw, prediction), 1e-15);
      } else {
        EXPECT_LT(distance_between(tracked.T_cw, world.true_T_cw()), 1e-6) << i;
      }
    }
  }
}

double squared_error(const MappedWorld& world, const Frame& frame, std::uint32_t i) {
  const sim::Match& match = frame.matches[i];
  const Eigen::Vector3d p_c = world.true_T_cw() * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
  const double u = match.u - frame.camera.fx * p_c.x() / p_c.z() - frame.camera.cx;
  const double v = match.v - frame.camera.fy * p_c.y() / p_c.z() - frame.camera.cy;
  return (u * u + v * v) * match.inv_sigma2;
}

// Outliers whose errors disagree with every pose near the truth.
TEST(PoseTracker, selects_no_outlier_in_a_world_without_other_errors) {
  WorldOptions options = perfect_world(max_matches);
  options.outlier_rate = 0.15;
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    SelectorSettings settings = settings_of(kind);
    settings.blocks.map_sigma = 0;  // as in the map
    PoseTracker tracker(settings, {});
    std::size_t outliers = 0, inliers = 0;
    track(sim::analytic_trajectory(2), options, tracker,
          [&](const MappedWorld& world, const Frame& frame, const TrackedFrame& tracked) {
            ASSERT_TRUE(tracked.is_tracked);
            for (std::uint32_t i = 0; i < frame.matches.size(); ++i) {
              if (squared_error(world, frame, i) > 8) ++outliers;
            }
            inliers += tracked.inliers.size();
            const auto& used = rejects_outliers(kind) ? tracked.selected : tracked.inliers;
            for (const std::uint32_t i : used) ASSERT_LT(squared_error(world, frame, i), 8);
          });
    EXPECT_GT(outliers, 500U);
    EXPECT_GT(inliers, 4 * outliers);
  }
}

std::vector<Pose> poses_with(SelectorKind kind, double map_sigma, Weighting weights = Weighting::measurement) {
  SelectorSettings settings = settings_of(kind);
  settings.blocks.map_sigma = map_sigma;
  settings.weights = weights;
  PoseTracker tracker(settings, {});
  std::vector<Pose> poses;
  track(sim::analytic_trajectory(1), small_world(max_matches), tracker,
        [&](const MappedWorld&, const Frame&, const TrackedFrame& tracked) { poses.push_back(tracked.T_cw); });
  return poses;
}

double distance_between(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double distance = 0;
  for (std::size_t i = 0; i < a.size(); ++i) distance += distance_between(a[i], b[i]);
  return distance;
}

TEST(PoseTracker, errors_of_the_map_count_with_all_weighted_alone) {
  for (const SelectorKind kind : sim::selector_kinds) {
    const double difference = distance_between(poses_with(kind, 0), poses_with(kind, 0.05));
    EXPECT_EQ(difference > 0, kind == SelectorKind::all_weighted) << to_string(kind);
  }
}

TEST(PoseTracker, errors_of_the_map_count_with_every_selector_if_configured) {
  const auto whitened = [](SelectorKind kind, double map_sigma) {
    return poses_with(kind, map_sigma, Weighting::measurement_and_map);
  };
  for (const SelectorKind kind : sim::selector_kinds) {
    const double difference = distance_between(whitened(kind, 0.05), poses_with(kind, 0.05));
    EXPECT_EQ(difference > 0, kind != SelectorKind::all_weighted) << to_string(kind);
    EXPECT_GT(distance_between(whitened(kind, 0.05), whitened(kind, 0.1)), 0) << to_string(kind);
  }
  const auto all = whitened(SelectorKind::all, 0.05);
  EXPECT_EQ(distance_between(all, poses_with(SelectorKind::all_weighted, 0.05)), 0) << "which takes them anyway";
  EXPECT_EQ(distance_between(all, whitened(SelectorKind::all_weighted, 0.05)), 0);
}

TEST(PoseTracker, covariances_of_a_frame_count_if_it_has_them) {
  const Trajectory trajectory = sim::analytic_trajectory(1);
  const auto poses_of = [&](SelectorKind kind, double metres, double map_sigma) {
    const sim::Rig rig = sim::forward_rig();
    MappedWorld world(trajectory, rig, small_world(max_matches), 1);
    SelectorSettings settings = settings_of(kind);
    settings.weights = Weighting::measurement_and_map;
    settings.blocks.map_sigma = map_sigma;
    PoseTracker tracker(settings, {});
    tracker.start((trajectory.poses.front().T_wb * rig.T_bc).inverse());
    std::vector<Pose> poses;
    Frame frame;
    while (world.next(frame)) {
      const double variance = metres * metres;
      frame.map_covariances.clear();
      if (metres > 0)
        frame.map_covariances.resize(frame.matches.size(), {variance, 0, 0, 0, variance, 0, 0, 0, variance});
      poses.push_back(tracker.track(frame).T_cw);
    }
    return poses;
  };
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    const auto told_by_frame = poses_of(kind, 0.05, 7);
    EXPECT_EQ(distance_between(told_by_frame, poses_of(kind, 0, 0.05)), 0);
    EXPECT_GT(distance_between(told_by_frame, poses_of(kind, 0.1, 7)), 0);
  }
}

// Residuals have the noise model of the selection: both are linearised at the start of the final optimisation.
TEST(PoseTracker, residuals_are_whitened_where_blocks_are_linearised) {
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    SelectorSettings settings = settings_of(kind);
    settings.weights = Weighting::measurement_and_map;
    PoseTracker tracker(settings, {});
    track(sim::analytic_trajectory(1), small_world(max_matches), tracker,
          [&](const MappedWorld&, const Frame& frame, const TrackedFrame& tracked) {
            const Pose start = sim::pose_of(frame.T_cw_prior);
            std::vector<sim::Whitening> whitenings;
            whiten(frame.camera, start, frame.matches, true, nullptr, settings.blocks.map_sigma, whitenings);
            const auto expected = reject_outliers(frame.camera, frame.matches, tracked.selected, start, {}, whitenings);
            ASSERT_TRUE(tracked.is_tracked);
            EXPECT_EQ(distance_between(tracked.T_cw, expected.estimate.T_cw), 0);
          });
  }
}

TEST(PoseTracker, keeps_constant_velocity_without_matches) {
  const Trajectory trajectory = sim::analytic_trajectory(1);
  PoseTracker tracker(settings_of(SelectorKind::md), {});
  track(trajectory, perfect_world(max_matches), tracker, [](const auto&...) {});
  Frame nothing;
  Pose expected = tracker.track(nothing).T_cw;
  const Pose step = expected.inverse() * tracker.predict();
  for (int i = 1; i < 200; ++i) {
    expected = expected * step;
    ASSERT_LT(distance_between(tracker.track(nothing).T_cw, expected), 1e-10) << i;
  }
}

}  // namespace
}  // namespace maxlogdet::test
