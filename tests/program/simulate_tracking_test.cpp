// SPDX-License-Identifier: MIT
// The experiments `euroc` and `budget`.
#include "tests/program/simulate.hpp"

#include <map>
#include <set>

namespace maxlogdet::test {
namespace {

TEST_F(Simulate, euroc_tracks_along_given_trajectories) {
  write_trajectory("first");
  write_trajectory("second");
  const Outcome outcome = run(small_tracking("euroc") + "--threads 1 --output one");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto rows = csv("one/euroc.csv");
  EXPECT_EQ(sim::joined(rows.at(0), ","),
            "sequence,selector,run,ate_m,rpe_m_per_s,roe_deg_per_s,ms_outliers,ms_selection,ms_pose");
  std::map<std::string, int> runs_of;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    ++runs_of[rows[i].at(1)];
    EXPECT_LT(std::stod(rows[i].at(3)), 1) << "m: it does not lose track";
    EXPECT_GT(std::stod(rows[i].at(8)), 0);
  }
  for (const char* const selector :
       {"quality", "bucket", "observability", "md", "quality_md", "inl", "all", "all_weighted", "random"}) {
    EXPECT_EQ(runs_of[selector], 4) << selector;
    EXPECT_NE(outcome.out.find(selector), std::string::npos);
  }
  EXPECT_EQ(rows.size(), 1 + 9 * 4U);
  EXPECT_EQ(draw("one").exit_code, 0);
  EXPECT_NE(contents("one/euroc.svg").find("<svg"), std::string::npos);
  EXPECT_EQ(contents("one/euroc.png").substr(1, 3), "PNG");
  EXPECT_EQ(nlohmann::json::parse(contents("one/euroc.json")).at("table").size(), 36U);

  ASSERT_EQ(run(small_tracking("euroc") + "--threads 2 --output two").exit_code, 0);
  EXPECT_EQ(without_times("one/euroc.csv"), without_times("two/euroc.csv"));
}

TEST_F(Simulate, euroc_takes_sequences_and_selectors_by_name) {
  write_trajectory("first");
  write_trajectory("second");
  ASSERT_EQ(run(small_tracking("euroc") + "--sequences second --selectors md,all --seconds 3.5 --output out").exit_code,
            0);
  const auto rows = csv("out/euroc.csv");
  ASSERT_EQ(rows.size(), 1 + 2 * 2U);
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_EQ(rows[i].at(0), "second");
  expect_refused(run(small_tracking("euroc") + "--sequences third"), "'third'; expected one of first, second");
  expect_refused(run(small_tracking("euroc") + "--selectors best"), "best");
}

TEST_F(Simulate, uses_the_built_in_trajectory_without_recorded_ones) {
  const Outcome outcome =
      run("budget --budgets 20 --runs 1 --seconds 4 --max-matches 60 --output out", "MAXLOGDET_DATA=nowhere ");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("the built-in one is used"), std::string::npos);
  EXPECT_EQ(csv("out/budget.csv").size(), 4U);
}

TEST_F(Simulate, budget_compares_budgets_with_all_inliers) {
  write_trajectory("first");
  ASSERT_EQ(run(small_tracking("budget") + "--budgets 20,60 --output out").exit_code, 0);
  const auto rows = csv("out/budget.csv");
  EXPECT_EQ(sim::joined(rows.at(0), ","), "sequence,selector,budget,run,ate_m,rpe_m_per_s,roe_deg_per_s");
  ASSERT_EQ(rows.size(), 1 + 4 * 2U);
  std::set<std::pair<std::string, std::string>> contestants;
  for (std::size_t i = 1; i < rows.size(); ++i) contestants.insert({rows[i].at(1), rows[i].at(2)});
  EXPECT_EQ(contestants, (std::set<std::pair<std::string, std::string>>{
                             {"md", "20"}, {"md", "60"}, {"inl", "0"}, {"all_weighted", "0"}}));
  EXPECT_EQ(draw("out").exit_code, 0);
  EXPECT_NE(contents("out/budget.svg").find("inl, median"), std::string::npos);
  EXPECT_NE(contents("out/budget.svg").find("all weighted, median"), std::string::npos);
}

TEST_F(Simulate, refuses_options_without_effect) {
  write_trajectory("first");
  const std::string euroc = small_tracking("euroc") + "--selectors ";
  const std::pair<std::string, std::string> refusals[] = {
      {"inl,all --budget 50", "--budget does nothing here; expected with it a selector"},
      {"md,inl --pool 150", "--pool does nothing here; expected with it --selectors quality_md"},
      {"random --strategy greedy", "--strategy does nothing here"},
      {"random --weighting measurement", "--weighting does nothing here"},
      {"md --map-sigma 0.1", "--map-sigma does nothing here"},
      {"inl --weights measurement --map-sigma 0.1", "--map-sigma does nothing here"},
      {"all_weighted --weights measurement_and_map", "--weights does nothing here"},
      {"inl --weights map_bias", "--weights"}};
  for (const auto& [arguments, message] : refusals) expect_refused(run(euroc + arguments), message);
  int number = 0;
  for (const char* const used : {"quality_md --pool 30 --strategy greedy --weighting measurement_and_map",
                                 "random,all_weighted", "random --weights measurement_and_map"}) {
    const std::string output = " --seconds 0.3 --map-sigma 0.1 --budget 20 --output out" + std::to_string(++number);
    EXPECT_EQ(run(euroc + used + output).exit_code, 0) << used;
  }
}

TEST_F(Simulate, trajectories_too_short_for_a_window_have_no_relative_error_but_pictures) {
  write_trajectory("first");
  const Outcome outcome = run(small_tracking("euroc") + "--seconds 2 --output out");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string warning =
      "maxlogdet_simulate: first is 2 s long, shorter than a window of 3 s: it has no relative errors\n";
  EXPECT_EQ(outcome.err, warning);
  EXPECT_EQ(csv("out/euroc.csv").at(1).at(4), "nan");
  EXPECT_TRUE(nlohmann::json::parse(contents("out/euroc.json")).at("table")[0].at("rpe_m_per_s").is_null());
  EXPECT_EQ(run(small_tracking("budget") + "--seconds 2 --budgets 20 --output out").err, warning);
  EXPECT_EQ(draw("out").out, "drew out/budget.svg and .png\ndrew out/euroc.svg and .png\n");
  expect_refused(run(small_tracking("euroc") + "--seconds 0.1 --output short"), "at least 3 poses of first");
}

}  // namespace
}  // namespace maxlogdet::test
