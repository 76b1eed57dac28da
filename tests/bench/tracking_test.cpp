// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking.hpp"

#include "bench/does_the_paper_hold/tracking_report.hpp"
#include "bench/world/hash.hpp"
#include "bench/world/pose_optimizer.hpp"
#include "tests/bench/flight.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::MappedWorld;
using sim::Pose;
using sim::PoseTracker;
using sim::SelectorKind;
using sim::TrackedFrame;
using sim::TrackingRuns;
using Indices = std::vector<std::uint32_t>;

constexpr std::size_t budget = 40;

double distance_between(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

Pose first_pose(const sim::Trajectory& trajectory) {
  return (trajectory.poses.front().T_wb * sim::euroc_T_bc()).inverse();
}

TEST(PoseTracker, is_exact_in_a_perfect_world_and_follows_its_prediction_without_matches) {
  const sim::Trajectory trajectory = flight(2);
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    PoseTracker tracker(sim::paper_selector(kind, budget), first_pose(trajectory));
    std::vector<Pose> poses = {first_pose(trajectory)};
    for_every_frame(trajectory, perfect_world(), 1, [&](const MappedWorld& world, Frame frame) {
      const bool is_blind = poses.size() > 10 && poses.size() < 14;
      if (is_blind) frame.matches.resize(poses.size() == 11 ? 0 : PoseTracker::min_inliers - 1);
      if (poses.size() > 1) {
        const Pose &last = poses.back(), &before = poses[poses.size() - 2];
        // The rotation of EuRoC's camera is given to 12 digits.
        EXPECT_LT(distance_between(tracker.predict(), last * before.inverse() * last), 1e-11);
      }
      const Pose prediction = tracker.predict();
      const TrackedFrame tracked = tracker.track(frame);
      EXPECT_EQ(tracked.is_tracked, !is_blind);
      // A step below 1e-6 is not taken.
      EXPECT_LT(distance_between(tracked.T_cw, is_blind ? prediction : world.true_T_cw()), is_blind ? 1e-15 : 1e-5);
      if (!is_blind) {
        EXPECT_EQ(tracked.selected.size(), has_budget(kind) ? budget : frame.matches.size());
      }
      poses.push_back(tracked.T_cw);
    });
    EXPECT_EQ(poses.size(), 42U);
  }
}

// The pipeline of section V, step by step: of selectors that draw nothing.
TEST(Tracking, a_run_is_its_steps_by_hand) {
  const sim::Trajectory trajectory = flight(5);
  const std::vector<SelectorKind> kinds = {SelectorKind::md, SelectorKind::inl, SelectorKind::all};
  std::vector<sim::SelectorSettings> selectors;
  for (const SelectorKind kind : kinds) selectors.push_back(sim::paper_selector(kind, budget));
  const auto outcomes = run_tracking(small_world(), selectors, trajectory, 5, 2);
  EXPECT_NE(run_tracking(small_world(), selectors, trajectory, 5, 3)[0].errors.ate_m, outcomes[0].errors.ate_m);
  for (std::size_t c = 0; c < kinds.size(); ++c) {
    SCOPED_TRACE(to_string(kinds[c]));
    std::vector<sim::StampedPose> estimate;
    Pose before = first_pose(trajectory), last = before;
    double matches = 0, used = 0;
    const std::uint64_t seed = sim::Draws(5 ^ sim::hash_of("flight"), 2).bits();
    for_every_frame(trajectory, small_world(), seed, [&](const MappedWorld&, Frame frame) {
      sim::RejectionOptions options;
      options.step_tolerance = 1e-6;
      Pose T = sim::orthonormal(last * before.inverse() * last);
      Indices chosen(frame.matches.size());
      std::iota(chosen.begin(), chosen.end(), 0U);
      matches += static_cast<double>(chosen.size());
      if (kinds[c] != SelectorKind::all) {
        const sim::Rejection of_all = reject_outliers(frame.camera, frame.matches, chosen, T, options);
        T = of_all.estimate.T_cw;
        chosen = of_all.inliers;
      }
      if (kinds[c] == SelectorKind::md && chosen.size() > budget) {
        Frame of_inliers = frame;
        of_inliers.T_cw_prior = sim::to_rows(T);
        of_inliers.matches.clear();
        for (const std::uint32_t i : chosen) of_inliers.matches.push_back(frame.matches[i]);
        BlockOptions block_options;
        block_options.weighting = Weighting::map_bias;
        BlockStore blocks;
        build_blocks(of_inliers, block_options, blocks);
        Indices selected;
        for (const std::uint32_t i : select_indices(blocks, with_budget(budget))) selected.push_back(chosen[i]);
        chosen = selected;
      }
      used += static_cast<double>(chosen.size());
      T = reject_outliers(frame.camera, frame.matches, chosen, T, options).estimate.T_cw;
      before = std::exchange(last, T);
      estimate.push_back({trajectory.poses[estimate.size()].time, T.inverse() * sim::euroc_T_bc().inverse()});
    });
    const auto expected = sim::trajectory_errors(estimate, trajectory.poses);
    EXPECT_NEAR(outcomes[c].errors.ate_m, expected.ate_m, 1e-9);
    EXPECT_NEAR(outcomes[c].errors.rpe_m_per_s, expected.rpe_m_per_s, 1e-9);
    EXPECT_NEAR(outcomes[c].errors.roe_deg_per_s, expected.roe_deg_per_s, 1e-7);
    EXPECT_GT(expected.ate_m, 1e-4);
    const auto frames = static_cast<double>(trajectory.poses.size());
    EXPECT_NEAR(outcomes[c].matches, matches / frames, 1e-9);
    EXPECT_NEAR(outcomes[c].used, used / frames, 1e-9);
    EXPECT_EQ(outcomes[c].lost, 0U);
    EXPECT_GT(outcomes[c].ms_pose, 0);
  }
}

sim::TrackingOutcome outcome_of(double rpe, double roe, double ate) {
  sim::TrackingOutcome outcome;
  outcome.errors.rpe_m_per_s = rpe;
  outcome.errors.roe_deg_per_s = roe;
  outcome.errors.ate_m = ate;
  outcome.ms_outliers = rpe;
  outcome.ms_selection = 0.25;
  outcome.ms_pose = 2;
  outcome.lost = 1;
  return outcome;
}

// Two sequences, two runs; in RPE md is worse than all in A and better in B, in ROE vice versa.
TrackingRuns hand_made() {
  TrackingRuns runs;
  runs.selectors = {"md", "inl", "all"};
  runs.sequences = {"A", "B"};
  runs.outcomes = {{{outcome_of(0.2, 1, 1), outcome_of(0.3, 4, 3), outcome_of(0.2, 2, 2)},
                    {outcome_of(0.4, 1, 3), outcome_of(0.3, 4, 3), outcome_of(0.1, 2, 2)}},
                   {{outcome_of(0.1, 3, 1), outcome_of(0.2, 1, 3), outcome_of(0.3, 2, 2)},
                    {outcome_of(0.1, 5, 1), outcome_of(0.2, 3, 3), outcome_of(0.3, 2, 2)}}};
  return runs;
}

TEST(TrackingReport, sequences_have_means_over_runs_and_selectors_means_over_sequences) {
  EXPECT_EQ(sim::to_csv(sequences_table(hand_made())),
            "sequence,selector,rpe_m_per_s,roe_deg_per_s,ate_m\n"
            "A,md,0.3000,1.000,2.0000\nA,inl,0.3000,4.000,3.0000\nA,all,0.1500,2.000,2.0000\n"
            "B,md,0.1000,4.000,1.0000\nB,inl,0.2000,2.000,3.0000\nB,all,0.3000,2.000,2.0000\n");
  // Means of runs 0.15 and 0.25: Student's 12.7062 times their deviation over the root of 2.
  const sim::Table means = means_table(hand_made());
  EXPECT_EQ(means.header.size(), 15U);
  EXPECT_EQ(sim::to_csv({means.rows[0], {}}),
            "md,0.20000,0.63531,2.50000,6.35310,1.50000,6.35310,1,1,0.1500,-0.2000,1,1,2.000,-1.000\n");
  EXPECT_EQ(sim::to_csv({means.rows[1], {}}),
            "inl,0.25000,0.00000,3.00000,6.35310,3.00000,0.00000,1,1,0.1500,-0.1000,1,0,2.000,\n");
}

// In percent of the other's mean: RPEs of inl are 0.25 in both runs, of md 0.15 and 0.25. Differences are -40 and 0 %.
TEST(TrackingReport, differences_have_the_interval_of_pairs) {
  const sim::Table table = differences_table(hand_made(), {"md"}, {"md", "inl", "all"});
  EXPECT_EQ(sim::to_csv(table),
            "selector,against,error,difference_percent,ci95,verdict\n"
            "md,inl,RPE,-20.0,254.1,open\nmd,inl,ROE,-16.7,0.0,better\nmd,inl,ATE,-50.0,211.8,open\n"
            "md,all,RPE,-11.1,423.5,open\nmd,all,ROE,25.0,317.7,open\nmd,all,ATE,-25.0,317.7,open\n");
}

TEST(TrackingReport, times_are_means_over_runs_and_lost_frames_a_sum) {
  EXPECT_EQ(sim::to_csv({times_table(hand_made()).rows[0], {}}), "md,0.200,0.250,2.000,2.450,0,0,4\n");
}

}  // namespace
}  // namespace maxlogdet::test
