// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_experiment.hpp"

#include "bench/does_the_paper_hold/runs.hpp"
#include "tests/bench/small_worlds.hpp"
#include "tests/bench/tracked_selectors.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <csignal>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::SelectorKind;
using sim::TrackingOptions;
using sim::TrackingOutcome;

constexpr std::size_t max_matches = 250;

TrackingOptions small_experiment() {
  TrackingOptions options;
  options.world = small_world(max_matches);
  options.selectors = {settings_of(SelectorKind::md), settings_of(SelectorKind::random),
                       settings_of(SelectorKind::inl)};
  options.window = 1;
  return options;
}

std::string without_times(std::vector<TrackingOutcome> outcomes) {
  for (TrackingOutcome& o : outcomes) o.ms_outliers = o.ms_selection = o.ms_pose = 0;
  return to_json(outcomes).dump();
}

TEST(Tracking, a_run_is_deterministic_except_for_times) {
  TrackingOptions options = small_experiment();
  sim::Trajectory trajectory = sim::analytic_trajectory(3);
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

TEST(Tracking, outcomes_describe_the_run) {
  TrackingOptions options = small_experiment();
  options.world = perfect_world(max_matches);
  const auto outcomes = run_tracking(options, sim::analytic_trajectory(3), sim::euroc_rig(), 0);
  ASSERT_EQ(outcomes.size(), 3U);
  for (const TrackingOutcome& o : outcomes) {
    EXPECT_LT(o.errors.ate_m + o.errors.rpe_m_per_s + o.errors.roe_deg_per_s, 1e-5);
    EXPECT_NEAR(o.errors.scale, 1, 1e-5);
    EXPECT_EQ(o.errors.windows, 41U) << "a second at 20 Hz, within 3 s";
    EXPECT_EQ(o.lost, 0U);
    EXPECT_EQ(o.matches, outcomes[0].matches) << "all see the same frames";
    EXPECT_GT(o.ms_outliers, 0);
  }
  EXPECT_NEAR(outcomes[0].used, 40, 2) << "frames with fewer matches use all";
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

TEST(Tracking, an_interrupted_run_is_null) {
  const sim::StopOnInterrupt guard;
  std::raise(SIGINT);
  const auto outcomes = run_tracking(small_experiment(), sim::analytic_trajectory(3), sim::forward_rig(), 0);
  EXPECT_TRUE(outcomes.empty());
  EXPECT_TRUE(to_json(outcomes).is_null());
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
  const auto json = to_json(outcomes);
  const auto back = sim::tracking_outcomes_of(nlohmann::json::parse(json.dump()));
  EXPECT_EQ(to_json(back).dump(), json.dump());
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].errors.ate_m, 0.3);
  EXPECT_EQ(back[0].lost, 3U);
  EXPECT_TRUE(std::isnan(back[1].errors.rpe_m_per_s));
}

}  // namespace
}  // namespace maxlogdet::test
