// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_experiment.hpp"

#include "tests/bench/small_worlds.hpp"
#include "tests/bench/tracked_selectors.hpp"
#include "tests/support/support.hpp"

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

std::vector<std::vector<double>> without_times(const std::vector<TrackingOutcome>& outcomes) {
  std::vector<std::vector<double>> values;
  for (const TrackingOutcome& o : outcomes) {
    values.push_back({o.errors.ate_m, o.errors.rpe_m_per_s, o.errors.roe_deg_per_s, o.matches, o.used});
  }
  return values;
}

TEST(Tracking, a_run_is_deterministic_except_for_times) {
  TrackingOptions options = small_experiment();
  sim::Trajectory trajectory = sim::analytic_trajectory(3);
  const auto outcomes_of = [&](std::uint64_t run) {
    return without_times(run_tracking(options, trajectory, sim::forward_rig(), run));
  };
  const auto first = outcomes_of(2);
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

}  // namespace
}  // namespace maxlogdet::test
