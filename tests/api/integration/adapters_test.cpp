// SPDX-License-Identifier: MIT
// What holds of every adapter, in a tracker with the lines of docs/trackers.md.
#include "tests/api/integration/adapter_world.hpp"
#include "tests/support/text_folder.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

// Runs a frame, of which all matches are candidates; the cost has to say the same.
std::set<std::size_t> continued_with(AdapterWorld& world, const char* status) {
  const std::set<std::size_t> kept = world.run();
  const HookCost& cost = world.hook().cost();
  EXPECT_STREQ(cost.status, status);
  EXPECT_EQ(cost.candidates, world.hook().features.size());
  EXPECT_EQ(cost.selected, kept.size());
  for (const double us : {cost.gather_us, cost.select_us, cost.optimize_us, cost.restore_us}) EXPECT_GE(us, 0);
  EXPECT_EQ(cost.hook_us(), cost.gather_us + cost.select_us + cost.restore_us);
  return kept;
}

TEST_P(AnyAdapter, blocks_are_derivatives_of_the_projection_under_a_left_perturbation) {
  const auto world = world_of(100, 20);
  const std::vector<SeenPoint> expected = world->seen();
  ASSERT_EQ(expected.size(), 100U);
  continued_with(*world, "ok");
  EXPECT_LT(largest_difference(world->hook().features.blocks(), expected), GetParam().tolerance);
}

TEST_P(AnyAdapter, the_tracker_continues_with_what_a_selector_selects) {
  const auto world = world_of(300, 100);
  const std::set<std::size_t> kept = continued_with(*world, "ok");
  const std::vector<std::uint32_t> expected = select_indices(world->hook().features.blocks(), world->hook().options);
  EXPECT_EQ(kept, std::set<std::size_t>(expected.begin(), expected.end()));
  EXPECT_EQ(kept.size(), 100U);
  for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(world->hook().features.is_selected(i), kept.count(i) > 0) << i;
}

TEST_P(AnyAdapter, few_candidates_and_after_an_error_all_of_them_continue_and_at_a_deadline_a_full_budget) {
  EXPECT_EQ(continued_with(*world_of(90, 100), "all_selected").size(), 90U);
  EXPECT_EQ(continued_with(*world_of(100, 100), "all_selected").size(), 100U);
  auto world = world_of(300, 100);
  world->hook().options.time_limit = 1e-9;
  EXPECT_EQ(continued_with(*world, "deadline_reached").size(), 100U);
  world->hook().options.time_limit = -1;
  EXPECT_EQ(continued_with(*world, "invalid_time_limit").size(), 300U);
  world->hook().features.block_options.min_depth = -1;
  EXPECT_EQ(continued_with(*world, "invalid_block_options").size(), 300U);
  world = world_of(300, 100);
  world->lose_pose();
  EXPECT_EQ(continued_with(*world, "invalid_pose").size(), 300U);
}

TEST_P(AnyAdapter, candidates_beyond_the_capacity_continue) {
  const std::set<std::size_t> kept = continued_with(*world_of(300, 100, 250), "capacity_exceeded");
  EXPECT_EQ(kept.size(), 150U);
  for (std::size_t i = 250; i < 300; ++i) EXPECT_EQ(kept.count(i), 1U) << i;
}

// An outlier that never enters the optimiser, or what the tracker has to judge itself.
TEST_P(AnyAdapter, what_is_not_finite_takes_no_place_of_the_budget) {
  for (const bool has_error : {false, true}) {
    for (const std::size_t budget : {100U, 500U}) {
      const auto world = world_of(300, budget);
      world->hook().options.time_limit = has_error ? -1 : 0;
      for (const std::size_t i : {7U, 8U}) world->make_not_finite(i);
      const std::set<std::size_t> kept = world->run();
      for (const std::size_t i : {7U, 8U}) {
        EXPECT_EQ(kept.count(i), world->has_outliers() ? 0U : 1U);
        EXPECT_EQ(world->is_outlier(i), world->has_outliers());
      }
      EXPECT_EQ(kept.size() - 2 * kept.count(7), has_error ? 298U : std::min<std::size_t>(budget, 298));
    }
  }
}

TEST_P(AnyAdapter, what_is_behind_the_camera_takes_no_place_of_the_budget) {
  const auto world = world_of(300, 100);
  world->put_behind_camera(7);
  const std::set<std::size_t> kept = continued_with(*world, "ok");
  EXPECT_EQ(kept.count(7), world->has_outliers() ? 0U : 1U);
  EXPECT_EQ(kept.size() - kept.count(7), 100U);
  EXPECT_EQ(world->is_outlier(7), world->has_outliers());
}

TEST_P(AnyAdapter, a_recorded_frame_has_all_candidates_as_they_were_before_the_optimisation) {
  const auto world = world_of(300, 100);
  const TemporaryFolder folder;
  ASSERT_TRUE(world->hook().record(folder.path().c_str()));
  const std::set<std::size_t> kept = world->run();
  const RecordedFrame frame(folder / "frame_000000.csv");
  ASSERT_EQ(frame.rows.size(), 300U);
  for (std::size_t row = 0; row < 300; ++row) {
    EXPECT_EQ(frame.at(row, "selected"), kept.count(row)) << row;
    for (const auto& [column, value] : world->recorded(row)) {
      EXPECT_DOUBLE_EQ(frame.at(row, column), value) << row << ' ' << column;
    }
  }
}

TEST_P(AnyAdapter, the_log_has_a_line_a_frame_of_what_cost_says) {
  const TemporaryFolder folder;
  std::string expected = "frame,status,candidates,selected,gather_ns,select_ns,optimize_ns,restore_ns\n";
  const auto world = world_of(300, 100);
  TrackerHook& hook = world->hook();
  EXPECT_STREQ(hook.cost().status, "none");
  EXPECT_FALSE(hook.log.open("/no/such/folder/hook.csv"));
  ASSERT_TRUE(hook.log.open((folder / "hook.csv").c_str()));
  for (int frame = 0; frame < 2; ++frame) {
    hook.options.budget = frame == 0 ? 100 : 400;
    const HookCost& cost = hook.cost();
    EXPECT_EQ(continued_with(*world, frame == 0 ? "ok" : "all_selected").size(), frame == 0 ? 100U : 300U);
    char line[200];
    const auto ns = [](double us) { return static_cast<long long>(1000 * us); };
    std::snprintf(line, sizeof line, "%d,%s,%zu,%zu,%lld,%lld,%lld,%lld\n", frame, cost.status, cost.candidates,
                  cost.selected, ns(cost.gather_us), ns(cost.select_us), ns(cost.optimize_us), ns(cost.restore_us));
    expected += line;
  }
  hook.log = HookLog();  // closes the file
  EXPECT_EQ(text_of(folder / "hook.csv"), expected);
}

}  // namespace
}  // namespace maxlogdet::test
