// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pose_tracker.hpp"

#include "tests/bench/small_worlds.hpp"
#include "tests/bench/tracked_selectors.hpp"
#include "tests/support/support.hpp"

#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::MappedWorld;
using sim::Pose;
using sim::PoseTracker;
using sim::SelectorKind;
using sim::TrackedFrame;
using sim::Trajectory;

constexpr std::size_t max_matches = 250;

double distance_between(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

// Calls body(world, frame, tracked) for every frame of a tracker that begins at the truth.
template <class Body>
void track(const Trajectory& trajectory, const sim::WorldOptions& options, PoseTracker& tracker, const Body& body) {
  const sim::Rig rig = sim::forward_rig();
  MappedWorld world(trajectory, rig, options, 1);
  tracker.start((trajectory.poses.front().T_wb * rig.T_bc).inverse());
  Frame frame;
  while (world.next(frame)) {
    const TrackedFrame tracked = tracker.track(frame);
    body(world, frame, tracked);
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

// Residuals have the noise model of the selection: both are linearised at the start of the final optimisation. Errors
// of the map count if so configured, and always with all_weighted.
TEST(PoseTracker, residuals_are_whitened_as_configured_where_blocks_are_linearised) {
  const sim::Rig rig = sim::forward_rig();
  const Trajectory trajectory = sim::analytic_trajectory(1);
  for (const SelectorKind kind : sim::selector_kinds) {
    for (const Weighting weights : {Weighting::measurement, Weighting::measurement_and_map}) {
      for (const bool has_covariances : {false, true}) {
        SCOPED_TRACE(std::string(to_string(kind)) + ' ' + to_string(weights) + (has_covariances ? " given" : ""));
        sim::SelectorSettings settings = settings_of(kind);
        settings.weights = weights;
        const bool weighs_map = weights == Weighting::measurement_and_map || kind == SelectorKind::all_weighted;
        MappedWorld world(trajectory, rig, small_world(max_matches), 1);
        PoseTracker tracker(settings, {});
        tracker.start((trajectory.poses.front().T_wb * rig.T_bc).inverse());
        Frame frame;
        while (world.next(frame)) {
          const double variance = 0.07 * 0.07;
          frame.map_covariances.clear();
          if (has_covariances) {
            frame.map_covariances.resize(frame.matches.size(), {variance, 0, 0, 0, variance, 0, 0, 0, variance});
          }
          const TrackedFrame tracked = tracker.track(frame);
          ASSERT_TRUE(tracked.is_tracked);
          const Pose start = sim::pose_of(frame.T_cw_prior);
          const double* const given = has_covariances ? frame.map_covariances.front().data() : nullptr;
          std::vector<sim::Whitening> whitenings;
          if (weighs_map) {
            whiten(frame.camera, start, frame.matches, true, given, settings.blocks.map_sigma, whitenings);
          }
          const auto expected = reject_outliers(frame.camera, frame.matches, tracked.selected, start, {}, whitenings);
          EXPECT_EQ(distance_between(tracked.T_cw, expected.estimate.T_cw), 0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
