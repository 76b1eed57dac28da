// SPDX-License-Identifier: MIT
#include "experiments/pose_tracker.hpp"
#include "experiments/runs.hpp"
#include "experiments/tracking_experiment.hpp"
#include "experiments/tracking_report.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <functional>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::MappedWorld;
using sim::Pose;
using sim::PoseTracker;
using sim::SelectorKind;
using sim::SelectorSettings;
using sim::TrackedFrame;
using sim::TrackingOptions;
using sim::TrackingOutcome;
using sim::TrackingRuns;
using sim::Trajectory;
using sim::WorldOptions;

WorldOptions small_world() {
  WorldOptions options;
  options.landmarks = 4000;
  options.max_matches = 250;
  return options;
}

WorldOptions perfect_world() {
  WorldOptions options = small_world();
  options.outlier_rate = options.pixel_sigma = 0;
  options.batch_translation = options.batch_rotation_deg = options.batch_scale = 0;
  options.depth_sigma = options.lateral_sigma = 0;
  return options;
}

SelectorSettings settings_of(SelectorKind kind) {
  SelectorSettings settings;
  settings.kind = kind;
  settings.budget = 40;
  settings.pool = 80;
  return settings;
}

double distance_between(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

// Calls body(world, frame, tracked) for every frame that a tracker begun at the truth has tracked.
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
    track(trajectory, perfect_world(), tracker, [&](const MappedWorld& world, const Frame& frame, const auto& tracked) {
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
  track(trajectory, small_world(), tracker, [&](const MappedWorld&, const Frame&, const TrackedFrame& tracked) {
    poses.push_back(tracked.T_cw);
    const Pose& last = poses[poses.size() - 1];
    const Pose& before = poses[poses.size() - 2];
    EXPECT_LT(distance_between(tracker.predict(), last * before.inverse() * last), 1e-12);
  });
  EXPECT_EQ(poses.size(), 22U);
}

TEST(PoseTracker, without_matches_follows_its_prediction_and_then_goes_on) {
  const Trajectory trajectory = sim::analytic_trajectory(2);
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    const sim::Rig rig = sim::forward_rig();
    MappedWorld world(trajectory, rig, perfect_world(), 1);
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

// Those that are so far off that no pose near the truth agrees with them.
TEST(PoseTracker, selects_no_outlier_in_a_world_that_is_right_otherwise) {
  WorldOptions options = perfect_world();
  options.outlier_rate = 0.15;
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    SelectorSettings settings = settings_of(kind);
    settings.blocks.map_sigma = 0;  // as the map is
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
  track(sim::analytic_trajectory(1), small_world(), tracker,
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

TEST(PoseTracker, errors_of_the_map_count_with_every_selector_if_told_so) {
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
    MappedWorld world(trajectory, rig, small_world(), 1);
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

// What a match weighs is what it was selected for: both are seen from where the pose of the selected ones begins.
TEST(PoseTracker, residuals_are_whitened_where_blocks_are_linearised) {
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    SelectorSettings settings = settings_of(kind);
    settings.weights = Weighting::measurement_and_map;
    PoseTracker tracker(settings, {});
    track(sim::analytic_trajectory(1), small_world(), tracker,
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

TrackingOptions small_experiment() {
  TrackingOptions options;
  options.world = small_world();
  options.selectors = {settings_of(SelectorKind::md), settings_of(SelectorKind::random),
                       settings_of(SelectorKind::inl)};
  options.window = 1;
  return options;
}

std::string without_times(std::vector<TrackingOutcome> outcomes) {
  for (TrackingOutcome& o : outcomes) o.ms_outliers = o.ms_selection = o.ms_pose = 0;
  return to_json(outcomes).dump();
}

TEST(Tracking, is_the_same_for_the_same_run_but_for_times) {
  TrackingOptions options = small_experiment();
  Trajectory trajectory = sim::analytic_trajectory(3);
  const auto outcomes_of = [&](std::uint64_t run) {
    return without_times(run_tracking(options, trajectory, sim::forward_rig(), run));
  };
  const std::string first = outcomes_of(2);
  EXPECT_EQ(outcomes_of(2), first);
  EXPECT_NE(outcomes_of(3), first);
  trajectory.name += "'";
  EXPECT_NE(outcomes_of(2), first);
  trajectory.name.pop_back();
  options.seed = 1;
  EXPECT_NE(outcomes_of(2), first);
}

TEST(Tracking, outcomes_say_what_happened) {
  TrackingOptions options = small_experiment();
  options.world = perfect_world();
  const auto outcomes = run_tracking(options, sim::analytic_trajectory(3), sim::euroc_rig(), 0);
  ASSERT_EQ(outcomes.size(), 3U);
  for (const TrackingOutcome& o : outcomes) {
    EXPECT_LT(o.errors.ate_m + o.errors.rpe_m_per_s + o.errors.roe_deg_per_s, 1e-5);
    EXPECT_NEAR(o.errors.scale, 1, 1e-5);
    EXPECT_EQ(o.errors.windows, 41U) << "a second at 20 Hz, within 3 s";
    EXPECT_EQ(o.lost, 0U);
    EXPECT_EQ(o.matches, outcomes[0].matches) << "all meet the same frames";
    EXPECT_GT(o.ms_outliers, 0);
  }
  EXPECT_NEAR(outcomes[0].used, 40, 2) << "of fewer matches in some frames all are used";
  EXPECT_EQ(outcomes[2].used, outcomes[2].matches);
}

TEST(Tracking, frames_without_matches_are_lost_and_poses_stay_finite) {
  TrackingOptions options = small_experiment();
  options.world.detection_rate = 0;
  for (const TrackingOutcome& o : run_tracking(options, sim::analytic_trajectory(30), sim::forward_rig(), 0)) {
    EXPECT_EQ(o.lost, 601U);
    EXPECT_EQ(o.matches + o.used, 0);
    EXPECT_TRUE(std::isfinite(o.errors.rpe_m_per_s));
  }
}

TEST(PoseTracker, goes_on_at_constant_velocity_for_as_long_as_it_sees_nothing) {
  const Trajectory trajectory = sim::analytic_trajectory(1);
  PoseTracker tracker(settings_of(SelectorKind::md), {});
  track(trajectory, perfect_world(), tracker, [](const auto&...) {});
  Frame nothing;
  Pose expected = tracker.track(nothing).T_cw;
  const Pose step = expected.inverse() * tracker.predict();
  for (int i = 1; i < 200; ++i) {
    expected = expected * step;
    ASSERT_LT(distance_between(tracker.track(nothing).T_cw, expected), 1e-10) << i;
  }
}

TEST(Tracking, an_interrupted_run_is_null) {
  const sim::StopOnInterrupt guard;
  std::raise(SIGINT);
  const auto outcomes = run_tracking(small_experiment(), sim::analytic_trajectory(3), sim::forward_rig(), 0);
  EXPECT_TRUE(outcomes.empty());
  EXPECT_TRUE(to_json(outcomes).is_null());
}

TrackingOutcome outcome_of(double rpe, double roe, double ate) {
  TrackingOutcome outcome;
  outcome.errors.rpe_m_per_s = rpe;
  outcome.errors.roe_deg_per_s = roe;
  outcome.errors.ate_m = ate;
  return outcome;
}

TEST(Tracking, outcomes_come_back_from_json) {
  TrackingOutcome o = outcome_of(0.1, 0.2, 0.3);
  o.errors.scale = 1.1;
  o.errors.windows = 17;
  o.ms_outliers = 1.5;
  o.ms_selection = 2.5;
  o.ms_pose = 3.5;
  o.matches = 200.25;
  o.used = 99.5;
  o.lost = 3;
  const std::vector<TrackingOutcome> outcomes = {o, outcome_of(std::nan(""), 1, 2)};
  const auto back = sim::tracking_outcomes_of(nlohmann::json::parse(to_json(outcomes).dump()));
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].errors.ate_m, 0.3);
  EXPECT_EQ(back[0].errors.rpe_m_per_s, 0.1);
  EXPECT_EQ(back[0].errors.roe_deg_per_s, 0.2);
  EXPECT_EQ(back[0].errors.scale, 1.1);
  EXPECT_EQ(back[0].errors.windows, 17U);
  EXPECT_EQ(back[0].ms_outliers, 1.5);
  EXPECT_EQ(back[0].ms_selection, 2.5);
  EXPECT_EQ(back[0].ms_pose, 3.5);
  EXPECT_EQ(back[0].matches, 200.25);
  EXPECT_EQ(back[0].used, 99.5);
  EXPECT_EQ(back[0].lost, 3U);
  EXPECT_TRUE(std::isnan(back[1].errors.rpe_m_per_s));
}

// Two sequences, two runs; md is worse than all in A and better in B, in RPE; and the other way round in ROE.
TrackingRuns hand_made() {
  TrackingRuns runs;
  runs.contestants = {"md", "quality", "inl", "all"};
  runs.sequences = {"A", "B"};
  runs.runs = {
      {"A", 0, {outcome_of(0.2, 1, 1), outcome_of(0.3, 2, 0.5), outcome_of(0.1, 4, 3), outcome_of(0.1, 2, 2)}},
      {"A", 1, {outcome_of(0.4, 1, 3), outcome_of(0.5, 2, 0.5), outcome_of(0.3, 4, 3), outcome_of(0.1, 2, 2)}},
      {"B", 0, {outcome_of(0.1, 3, 1), outcome_of(0.1, 2, 4), outcome_of(0.2, 1, 3), outcome_of(0.3, 2, 2)}},
      {"B", 1, {outcome_of(0.1, 5, 1), outcome_of(0.1, 2, 4), outcome_of(0.2, 3, 3), outcome_of(0.3, 2, 2)}},
  };
  return runs;
}

using Row = std::vector<std::string>;

TEST(TrackingReport, csv_has_an_outcome_a_row) {
  TrackingRuns runs = hand_made();
  runs.runs[1].outcomes[2].ms_outliers = 1.5;
  runs.runs[1].outcomes[2].ms_selection = 0.25;
  runs.runs[1].outcomes[2].ms_pose = 7;
  const sim::Table table = euroc_table(runs);
  EXPECT_EQ(sim::to_csv({table.header, {}}),
            "sequence,selector,run,ate_m,rpe_m_per_s,roe_deg_per_s,ms_outliers,ms_selection,ms_pose\n");
  ASSERT_EQ(table.rows.size(), 16U);
  EXPECT_EQ(sim::to_csv({table.rows[6], {}}), "A,inl,1,3,0.3,4,1.5,0.25,7\n");
}

TEST(TrackingReport, relative_errors_are_averaged_and_compared_with_all) {
  const sim::Table table = relative_error_table(hand_made());
  EXPECT_EQ(table.header, Row({"RPE (m/s), ROE (deg/s)", "md", "quality", "inl", "all"}));
  ASSERT_EQ(table.rows.size(), 7U);
  EXPECT_EQ(table.rows[0], Row({"A", "**0.3000** **1.000**", "0.4000 2.000", "0.2000 4.000", "**0.1000** **2.000**"}));
  EXPECT_EQ(table.rows[1],
            Row({"B", "**0.1000** 4.000", "**0.1000** **2.000**", "**0.2000** **2.000**", "0.3000 **2.000**"}));
  EXPECT_EQ(table.rows[2],
            Row({"average", "**0.2000** 2.500", "0.2500 **2.000**", "**0.2000** 3.000", "**0.2000** **2.000**"}));
  EXPECT_EQ(table.rows[3], Row({"sequences worse than all", "1 1", "1 0", "1 1", "0 0"}));
  EXPECT_EQ(table.rows[4], Row({"sequences better than all", "1 1", "1 0", "1 0", "0 0"}));
  EXPECT_EQ(table.rows[5], Row({"average loss there", "0.2000 2.000", "0.3000 -", "0.1000 2.000", "- -"}));
  EXPECT_EQ(table.rows[6], Row({"average gain there", "-0.2000 -1.000", "-0.2000 -", "-0.1000 -", "- -"}));
}

TEST(TrackingReport, absolute_errors_have_average_minimum_and_maximum) {
  const sim::Table table = absolute_error_table(hand_made());
  ASSERT_EQ(table.rows.size(), 5U);
  EXPECT_EQ(table.rows[0], Row({"A", "2.0000", "**0.5000**", "3.0000", "2.0000"}));
  EXPECT_EQ(table.rows[1], Row({"B", "**1.0000**", "4.0000", "3.0000", "2.0000"}));
  EXPECT_EQ(table.rows[2], Row({"average", "1.5000", "2.2500", "3.0000", "2.0000"}));
  EXPECT_EQ(table.rows[3], Row({"minimum", "1.0000", "0.5000", "3.0000", "2.0000"}));
  EXPECT_EQ(table.rows[4], Row({"maximum", "2.0000", "4.0000", "3.0000", "2.0000"}));
}

TEST(TrackingReport, what_is_missing_is_not_the_lowest) {
  TrackingRuns runs = hand_made();
  runs.sequences = {"A", "none"};
  EXPECT_EQ(relative_error_table(runs).rows[1], Row({"none", "- -", "- -", "- -", "- -"}));
  EXPECT_EQ(absolute_error_table(runs).rows[1], Row({"none", "-", "-", "-", "-"}));
}

TEST(TrackingReport, times_are_means_over_runs_and_lost_frames_a_sum) {
  TrackingRuns runs = hand_made();
  for (std::size_t i = 0; i < 4; ++i) {
    TrackingOutcome& o = runs.runs[i].outcomes[0];
    o.ms_outliers = static_cast<double>(i);
    o.ms_selection = 0.25;
    o.ms_pose = 2;
    o.matches = 300;
    o.used = 100;
    o.lost = i;
  }
  const sim::Table table = time_table(runs);
  ASSERT_EQ(table.rows.size(), 4U);
  EXPECT_EQ(table.rows[0], Row({"md", "1.500", "0.250", "2.000", "3.750", "300", "100", "6"}));
}

// Errors of `ours` and `theirs` over 20 runs of two sequences, in all three errors.
TrackingRuns duel(const std::function<double(std::size_t run)>& ours,
                  const std::function<double(std::size_t run)>& theirs) {
  TrackingRuns runs;
  runs.contestants = {"quality", "md"};
  runs.sequences = {"A", "B"};
  for (std::size_t run = 0; run < 20; ++run) {
    for (const double scale : {1.0, 3.0}) {
      const double a = scale * theirs(run), b = scale * ours(run);
      runs.runs.push_back({scale == 1 ? "A" : "B", run, {outcome_of(a, a, a), outcome_of(b, b, b)}});
    }
  }
  return runs;
}

double spread(std::size_t run) { return 1 + 0.3 * std::sin(static_cast<double>(run)); }

TEST(TrackingReport, claims_what_can_be_told) {
  const auto verdict_of = [](const TrackingRuns& runs, std::size_t column) {
    const sim::Table table = claim_table(runs, "md");
    EXPECT_EQ(table.rows.size(), 1U);
    EXPECT_EQ(table.rows[0][0], "quality");
    return table.rows[0].at(column);
  };
  const auto ends_with = [](const std::string& text, const std::string& end) {
    return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
  };
  for (std::size_t column = 1; column < 4; ++column) {
    // Both met the same frames: 10 % can be told although the runs differ by 60 %.
    const auto better = verdict_of(duel([](auto run) { return 0.9 * spread(run); }, spread), column);
    const auto worse = verdict_of(duel([](auto run) { return 1.1 * spread(run); }, spread), column);
    const auto noise = verdict_of(duel([](auto run) { return 1.01 * spread(run + 7); }, spread), column);
    const auto equal = verdict_of(duel(spread, spread), column);
    EXPECT_EQ(better.rfind("-10.0 ± ", 0), 0U) << better;
    EXPECT_EQ(worse.rfind("10.0 ± ", 0), 0U) << worse;
    EXPECT_TRUE(ends_with(better, " % ▲")) << better;
    EXPECT_TRUE(ends_with(worse, " % ▼")) << worse;
    EXPECT_TRUE(ends_with(noise, " % ·")) << noise;
    EXPECT_TRUE(ends_with(equal, " % ·")) << equal;
  }
  EXPECT_TRUE(claim_table(duel(spread, spread), "nobody").rows.empty());
}

// In per cent of the other's mean: theirs (2 + 4) / 2 = 3 and (3 + 9) / 2 = 6, mean 4.5; ours 2 and 6. Differences -1
// and 0: -22.2 and 0, mean -11.1, interval 12.7062 * 15.713 / sqrt(2).
TEST(TrackingReport, claims_have_the_interval_of_paired_differences) {
  TrackingRuns runs;
  runs.contestants = {"md", "all"};
  runs.sequences = {"A", "B"};
  runs.runs = {{"A", 0, {outcome_of(1, 1, 1), outcome_of(2, 2, 2)}},
               {"A", 1, {outcome_of(4, 1, 1), outcome_of(3, 2, 2)}},
               {"A", 2, {outcome_of(100, 1, 1), outcome_of(1, 2, 2)}},  // B was not reached: does not count
               {"B", 0, {outcome_of(3, 1, 1), outcome_of(4, 2, 2)}},
               {"B", 1, {outcome_of(8, 1, 1), outcome_of(9, 2, 2)}}};
  const sim::Table table = claim_table(runs, "md");
  EXPECT_EQ(table.rows[0], Row({"all", "-11.1 ± 141.2 % ·", "-50.0 ± 0.0 % ▲", "-50.0 ± 0.0 % ▲"}));
}

TEST(TrackingReport, budgets_have_their_quartiles) {
  std::vector<SelectorSettings> contestants = {settings_of(SelectorKind::md), settings_of(SelectorKind::md),
                                               settings_of(SelectorKind::inl)};
  contestants[1].budget = 60;
  TrackingRuns runs;
  runs.contestants = {"md", "md", "inl"};
  runs.sequences = {"A"};
  for (std::size_t run = 0; run < 5; ++run) {
    const auto e = static_cast<double>(run + 1);
    runs.runs.push_back({"A", run, {outcome_of(e, 10 * e, 100 * e), outcome_of(2, 2, 2), outcome_of(3, 3, 3)}});
  }
  const sim::Table summary = budget_summary(runs, contestants);
  ASSERT_EQ(summary.rows.size(), 3U);
  EXPECT_EQ(summary.rows[0],
            Row({"40", "300.0000 [200.0000, 400.0000]", "3.0000 [2.0000, 4.0000]", "30.0000 [20.0000, 40.0000]",
                 "9900.0 ± 6544.1 % ▼", "0.0 ± 65.4 % ·", "900.0 ± 654.4 % ▼"}));
  EXPECT_EQ(summary.rows[1], Row({"60", "2.0000 [2.0000, 2.0000]", "2.0000 [2.0000, 2.0000]", "2.0000 [2.0000, 2.0000]",
                                  "-33.3 ± 0.0 % ▲", "-33.3 ± 0.0 % ▲", "-33.3 ± 0.0 % ▲"}));
  EXPECT_EQ(summary.rows[2], Row({"inl", "3.0000 [3.0000, 3.0000]", "3.0000 [3.0000, 3.0000]",
                                  "3.0000 [3.0000, 3.0000]", "-", "-", "-"}));
  const sim::Table table = budget_table(runs, contestants);
  EXPECT_EQ(sim::to_csv({table.header, {}}), "sequence,selector,budget,run,ate_m,rpe_m_per_s,roe_deg_per_s\n");
  ASSERT_EQ(table.rows.size(), 15U);
  EXPECT_EQ(table.rows[3], Row({"A", "md", "40", "1", "200", "2", "20"}));
  EXPECT_EQ(table.rows[5], Row({"A", "inl", "0", "1", "3", "3", "3"}));
}

TEST(TrackingReport, averages_have_the_interval_over_runs_of_the_means_over_sequences) {
  TrackingRuns runs;
  runs.contestants = {"md"};
  runs.sequences = {"A", "B"};
  for (std::size_t run = 0; run < 2; ++run) {
    const auto e = static_cast<double>(run);  // means over A and B: 2 and 3
    runs.runs.push_back({"A", run, {outcome_of(1 + e, 10, 100)}});
    runs.runs.push_back({"B", run, {outcome_of(3 + e, 30, 300)}});
  }
  const sim::Table table = average_table(runs);
  // Student's 12.7062 times the deviation of 2 and 3 over the root of 2.
  EXPECT_EQ(table.rows.at(0), Row({"md", "2.50000 ± 6.35310", "20.00000 ± 0.00000", "200.00000 ± 0.00000"}));
  runs.runs.pop_back();  // the second run lacks a sequence
  EXPECT_EQ(average_table(runs).rows.at(0), Row({"md", "2.00000", "20.00000", "200.00000"}));
}

}  // namespace
}  // namespace maxlogdet::test
