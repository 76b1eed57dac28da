// SPDX-License-Identifier: MIT
// What a verdict says of evaluations whose numbers are given.
#include "bench/does_it_help/verdict.hpp"

#include <gtest/gtest.h>

#include <string>

namespace maxlogdet::test {
namespace {

using sim::Cost;
using sim::Estimate;
using sim::Evaluation;
using sim::EvaluationRow;
using sim::Verdict;

Estimate within_tenth(double value) { return {value, {0.9 * value, 1.1 * value}}; }

// Of a growth in translation and in rotation, and both squared deviations over those of random matches.
EvaluationRow row_of(const std::string& selector, std::size_t budget, double m, double rad, double m_of_random = 0.5,
                     double rad_of_random = 0.5) {
  EvaluationRow row;
  row.selector = selector;
  row.budget = budget;
  row.has_budget = selector != "aligned";
  row.frames = 50;
  row.costs[0].growth = within_tenth(m);
  row.costs[1].growth = within_tenth(rad);
  row.costs[0].of_random = within_tenth(m_of_random);
  row.costs[1].of_random = within_tenth(rad_of_random);
  return row;
}

Evaluation evaluation_of(std::vector<EvaluationRow> rows) {
  Evaluation evaluation;
  evaluation.frames = 50;
  evaluation.matches = 350;
  evaluation.inliers = 300;
  evaluation.chi2 = evaluation.median_chi2 = 1;
  evaluation.chi2_by_leverage.fill(within_tenth(1));
  evaluation.cell_correlation = within_tenth(0.01);
  evaluation.rows = std::move(rows);
  evaluation.rows.push_back(row_of("random_gated", 100, 0.6, 0.5, 1, 1));
  evaluation.rows.push_back(row_of("aligned", 290, 0.02, 0.03));
  return evaluation;
}

// Max-logDet at the usual budget alone.
Verdict verdict_at(double m, double rad, double m_of_random, double rad_of_random) {
  return verdict_of(evaluation_of({row_of("md", 100, m, rad, m_of_random, rad_of_random)}));
}

std::string all_of(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + "\n";
  return all;
}

void expect_begins(const Verdict& verdict, const std::string& text) {
  EXPECT_EQ(verdict.text.rfind(text, 0), 0U) << verdict.text;
}

void expect_advice(const Verdict& verdict, const std::string& text) {
  EXPECT_NE(all_of(verdict.advice).find(text), std::string::npos) << all_of(verdict.advice);
}

TEST(Verdict, names_the_parts_in_which_a_selection_is_better_or_worse_than_random) {
  expect_begins(verdict_at(0.1, 0.2, 0.5, 0.6), "Max-logDet pays: with 100 of some 300 inliers the standard deviation");
  expect_begins(verdict_at(0.1, 0.2, 0.5, 1.3),
                "Max-logDet pays in translation, but in rotation it is worse than random: with 100");
  expect_begins(
      verdict_at(0.1, 0.2, 1, 0.5),
      "Max-logDet pays in rotation, but in translation these frames show no difference from random: with 100");
  expect_begins(verdict_at(0.1, 0.2, 1.3, 1.3), "Max-logDet does not help here: with 100");
  expect_begins(verdict_at(0.1, 0.2, 1.3, 1),
                "Max-logDet does not help here, and is worse than random in translation: with 100");
  expect_begins(verdict_at(0.1, 0.2, 1, 1), "These frames cannot tell whether Max-logDet helps: with 100");
  EXPECT_EQ(verdict_at(0.1, 0.2, 0.5, 1.3).recommended, "md");
  EXPECT_EQ(verdict_at(0.1, 0.2, 1.3, 1.3).recommended, "aligned");
}

TEST(Verdict, advises_the_smallest_budget_for_each_growth) {
  const Verdict verdict = verdict_of(
      evaluation_of({row_of("md", 60, 0.19, 0.3), row_of("md", 100, 0.12, 0.19, 0.5, 1.02),
                     row_of("md", 150, 0.04, 0.08), row_of("md", 200, 0.03, 0.06), row_of("md", 230, 0.01, 0.01)}));
  expect_begins(verdict, "Max-logDet pays");
  expect_advice(verdict, "at most 5 %, 230; at most 10 %, 150; at most 20 %, 100 (no better than random in rotation).");
  expect_advice(verdict,
                "For the pose alone, do not select, take pose(): its standard deviation grows by 2.0 % (1.8 to");
}

TEST(Verdict, does_not_advise_a_selection_whose_growth_no_budget_limits) {
  const Verdict verdict = verdict_of(evaluation_of({row_of("md", 100, 0.4, 0.3), row_of("md", 200, 0.21, 0.1)}));
  expect_begins(verdict,
                "Do not select, take pose(): no budget that was tried keeps the growth of the standard deviation "
                "within 20 %. Max-logDet is "
                "better than random: with 100");
  EXPECT_EQ(verdict.recommended, "aligned");
  expect_advice(verdict, "For later steps, use all inliers, or try larger --budgets.");
}

TEST(Verdict, does_not_advise_a_pose_that_is_far_from_that_of_all) {
  Evaluation evaluation = evaluation_of({row_of("md", 100, 0.1, 0.1)});
  evaluation.rows.back() = row_of("aligned", 290, 0.02, 0.4);
  expect_advice(verdict_of(evaluation), "For the pose alone, optimise with all inliers, not pose(), whose");
  evaluation.rows[0] = row_of("md", 100, 0.4, 0.4);
  expect_begins(verdict_of(evaluation), "Do not select, optimise with all inliers: no budget that was tried keeps");
}

TEST(Verdict, names_errors_that_matches_share) {
  Evaluation evaluation = evaluation_of({row_of("md", 100, 0.4, 0.3), row_of("md_spread", 100, 0.1, 0.1)});
  evaluation.cell_correlation = within_tenth(0.1);
  expect_begins(verdict_of(evaluation),
                "Your matches share errors: residuals of neighbours are correlated by 0.10. Max-logDet spread over the "
                "image pays: with 100");
  EXPECT_EQ(verdict_of(evaluation).recommended, "md_spread");
  evaluation.cell_correlation.interval.low = 0.01;
  EXPECT_FALSE(verdict_of(evaluation).shares_errors) << "by chance";
}

TEST(Verdict, explains_chi2_that_rises_with_leverage) {
  Evaluation evaluation = evaluation_of({row_of("md", 100, 0.1, 0.1)});
  evaluation.chi2_by_leverage.back() = within_tenth(2);
  expect_begins(verdict_of(evaluation), "Max-logDet pays");
  expect_advice(verdict_of(evaluation), "chi-squared is 2.00, and that of all 1.00. Growth is measured, so it stands.");
}

TEST(Verdict, cannot_tell_without_noise_frames_or_a_choice) {
  Evaluation evaluation = evaluation_of({row_of("md", 100, 0.1, 0.1)});
  evaluation.rows[0].frames = 9;
  expect_begins(verdict_of(evaluation), "These frames cannot tell: only 9 have more than 100 matches");
  evaluation.rows[0].frames = 0;
  expect_begins(verdict_of(evaluation), "These frames cannot tell: none has more matches than the smallest budget.");
  evaluation = evaluation_of({row_of("md", 241, 0.1, 0.1)});
  expect_begins(verdict_of(evaluation), "These frames cannot tell: 241 matches are nearly all of some 300 inliers");
  evaluation.median_chi2 = 1e-7;
  evaluation.cell_correlation = within_tenth(0.3);
  expect_begins(verdict_of(evaluation), "These frames cannot tell: their residuals are rounding errors");
  EXPECT_FALSE(verdict_of(evaluation).shares_errors);
  EXPECT_TRUE(verdict_of(evaluation).advice.empty());
}

}  // namespace
}  // namespace maxlogdet::test
