// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_report.hpp"

#include "tests/bench/tracked_selectors.hpp"
#include "tests/support/support.hpp"

#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::SelectorKind;
using sim::TrackingRuns;

// Two sequences, two runs; md is worse than all in A and better in B, in RPE; and vice versa in ROE.
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
    sim::TrackingOutcome& o = runs.runs[i].outcomes[0];
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

// In percent of the other's mean: theirs are (2 + 4) / 2 = 3 and (3 + 9) / 2 = 6, mean 4.5; ours 2 and 6. Differences
// -1 and 0: -22.2 and 0, mean -11.1, interval 12.7062 * 15.713 / sqrt(2).
TEST(TrackingReport, claims_have_the_interval_of_paired_differences) {
  TrackingRuns runs;
  runs.contestants = {"md", "all"};
  runs.sequences = {"A", "B"};
  runs.runs = {{"A", 0, {outcome_of(1, 1, 1), outcome_of(2, 2, 2)}},
               {"A", 1, {outcome_of(4, 1, 1), outcome_of(3, 2, 2)}},
               {"A", 2, {outcome_of(100, 1, 1), outcome_of(1, 2, 2)}},  // without B: not counted
               {"B", 0, {outcome_of(3, 1, 1), outcome_of(4, 2, 2)}},
               {"B", 1, {outcome_of(8, 1, 1), outcome_of(9, 2, 2)}}};
  const sim::Table table = claim_table(runs, "md");
  EXPECT_EQ(table.rows[0], Row({"all", "-11.1 ± 141.2 % ·", "-50.0 ± 0.0 % ▲", "-50.0 ± 0.0 % ▲"}));
}

TEST(TrackingReport, budgets_have_their_quartiles) {
  std::vector<sim::SelectorSettings> contestants = {settings_of(SelectorKind::md), settings_of(SelectorKind::md),
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
