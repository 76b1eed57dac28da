// SPDX-License-Identifier: MIT
// What evaluations conclude: of simulated frames whose errors are known, and of given numbers.
#include "cli/report.hpp"

#include "tests/bench/simulated_frames.hpp"
#include "tests/support/support.hpp"

#include <string>

namespace maxlogdet::test {
namespace {

using sim::Cost;
using sim::Evaluation;
using sim::EvaluationOptions;
using sim::EvaluationRow;
using sim::Interval;
using sim::Statistic;
using sim::Verdict;

bool contains(const Interval& interval, double value) { return interval.low <= value && value <= interval.high; }

void expect_begins(const std::string& text, const std::string& beginning) {
  EXPECT_EQ(text.rfind(beginning, 0), 0U) << text;
}

Evaluation evaluated(const std::vector<Frame>& frames, std::vector<std::size_t> budgets = {30, 60, 100}) {
  EvaluationOptions options;
  options.budgets = std::move(budgets);
  options.repeats = 4;
  return sim::evaluate({frames}, options, 2);
}

// Whether a number is where the model has it; intervals of resamples of eight blocks are too narrow.
bool is_near(const Statistic& estimate, double expected) {
  return contains(estimate.interval, (estimate.value + expected) / 2);
}

// E|x_S - x_all|^2 over the variance of x_all, from the growth of the standard deviation.
double squared(double growth) { return (1 + growth) * (1 + growth) - 1; }

struct Errors {
  FrameKind kind;
  double sigmas;         // times as large as modelled
  bool has_map = false;  // points have errors, too
};

class EvaluationOf : public ::testing::TestWithParam<Errors> {};

// Errors of a point by a covariance of its own.
void move_points(Random& random, Frame& frame, double sigmas) {
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    const Eigen::Matrix3d covariance = random_covariance(random, 0.1, 1e-5);
    const Eigen::Vector3d draws(normal(random), normal(random), normal(random));
    Eigen::Map<Eigen::Vector3d>(frame.matches[i].point) += sigmas * cholesky(covariance) * draws;
    set_covariance(frame, i, covariance);
  }
}

// However small, they are noise: deviations and the pose of all inliers are measured on the same scale. Each growth is
// judged by its own interval: those of 4 % scatter by a third of their square. Of 80 frames one in ten recordings was
// beyond these limits, of 200 none of 140.
TEST_P(EvaluationOf, independent_errors_of_any_size_has_ratios_of_one_and_no_correlation) {
  const Errors& errors = GetParam();
  const double variance = errors.sigmas * errors.sigmas;
  TracedRandom random;
  const std::size_t count = std::max<std::size_t>(20, trials(200));
  const auto frames = simulated_recording(random, errors.kind, count, 200, [&](Frame& frame) {
    add_errors(random, frame, errors.sigmas);
    if (errors.has_map) move_points(random, frame, errors.sigmas);
  });
  const Evaluation evaluation = evaluated(frames);
  if (count < 200) return;  // under sanitizers, which take minutes for as many frames as statistics need
  EXPECT_NEAR(evaluation.inliers, 0.995 * 200, 0.8) << "the limits are quantiles, of a scale that scatters";
  double values = 0, log_ratios[2] = {};  // of translation and rotation
  std::size_t far_outside = 0;
  for (const EvaluationRow& row : evaluation.rows) {
    if (row.selector != "md" && row.selector != "md_spread" && row.selector != "random_gated") continue;
    for (const std::size_t part : {0U, 1U}) {
      const Cost& cost = row.costs[part];
      log_ratios[part] += std::log(squared(cost.growth.value) / squared(cost.predicted));
      far_outside += is_near(cost.growth, cost.predicted) ? 0 : 1;
    }
    ++values;
  }
  for (const double sum : log_ratios) EXPECT_NEAR(sum / values, 0, 0.17);
  EXPECT_LE(far_outside, 2U) << "of 18";
  EXPECT_NEAR(evaluation.chi2 / variance, 1, 0.1);
  for (const Statistic& chi2 : evaluation.chi2_by_leverage) EXPECT_NEAR(chi2.value / variance, 1, 0.1);
  EXPECT_TRUE(is_near(evaluation.cell_correlation, 0));
  EXPECT_NEAR(evaluation.cell_correlation.value, 0, 0.02);
  EXPECT_TRUE(verdict_of(evaluation).has_noise);
  EXPECT_FALSE(verdict_of(evaluation).shares_errors);
  for (const Cost& cost : evaluation.row("aligned", 0)->costs) EXPECT_LT(cost.growth.value, 0.1);
}

constexpr Errors every_error[] = {{FrameKind::monocular, 1},    {FrameKind::stereo, 0.4}, {FrameKind::stereo, 0.05},
                                  {FrameKind::stereo, 1, true}, {FrameKind::depth, 2.5},  {FrameKind::fisheye, 1},
                                  {FrameKind::rig, 1}};
INSTANTIATE_TEST_SUITE_P(EveryKindOfFrame, EvaluationOf, ::testing::ValuesIn(every_error), [](const auto& of) {
  const std::string percent = std::to_string(std::lround(100 * of.param.sigmas));
  return to_string(of.param.kind) + ("_" + percent) + (of.param.has_map ? "_with_map" : "");
});

// Matches of equal noise, half of whose variance of 1 px^2 a cell shares.
TEST(EvaluationOfErrors, that_cells_share_are_found_of_their_true_size) {
  TracedRandom random;
  const auto add = [&](Frame& frame) {
    std::vector<Eigen::Vector2d> field(sim::noise_grid.cells());
    for (Eigen::Vector2d& of_cell : field) of_cell = std::sqrt(0.5) * Eigen::Vector2d(normal(random), normal(random));
    for (Match& match : frame.matches) {
      const Eigen::Vector2d& shared = field[sim::noise_grid.cell_of(frame, match)];
      shift(match, shared.x(), shared.y());
    }
    add_errors(random, frame, std::sqrt(0.5));
  };
  const Evaluation evaluation = evaluated(simulated_recording(random, FrameKind::stereo, 60, 300, add, 1));
  const Statistic& found = evaluation.cell_correlation;
  // The pose takes 6 of the 96 shared errors of a frame, which is not corrected: some 6 % of them. The rest is what
  // 60 frames leave of chance, other on each compiler, which may order the draws of an expression as it likes.
  EXPECT_NEAR(found.value, 0.94 * 0.5, 0.15 * 0.5);
  EXPECT_GT(found.interval.low, 0);
  EXPECT_LT(found.interval.high - found.interval.low, 0.5 * 0.5);
  EXPECT_TRUE(verdict_of(evaluation).shares_errors);
  const Cost& translation = evaluation.row("md", 30)->costs[0];
  EXPECT_GT(translation.growth.interval.low, translation.predicted);
}

TEST(EvaluationOfErrors, independent_ones_make_selection_pay) {
  TracedRandom random;
  const auto add = [&](Frame& frame) { add_errors(random, frame); };
  const std::vector<std::size_t> budgets = {30, 60, 100, 150, 200};
  const Evaluation evaluation = evaluated(simulated_recording(random, FrameKind::stereo, 40, 300, add), budgets);
  for (const std::size_t budget : budgets) {
    for (const std::size_t part : {0U, 1U}) {
      const Statistic& md = evaluation.row("md", budget)->costs[part].of_random;
      EXPECT_LT(md.interval.high, 1);
      EXPECT_LT(md.value, 0.8);
      EXPECT_TRUE(contains(md.interval, md.value));
      EXPECT_EQ(evaluation.row("random_gated", budget)->costs[part].of_random.value, 1);
      EXPECT_NEAR(evaluation.row("random", budget)->costs[part].of_random.value, 1.1, 0.3);
    }
  }
  const Verdict verdict = verdict_of(evaluation);
  expect_begins(verdict.text, "Max-logDet pays: with 100 of some 29");
  EXPECT_EQ(verdict.recommended, "md");
}

TEST(EvaluationOfErrors, of_wrong_matches_show_what_the_gate_brings) {
  TracedRandom random;
  const auto frames = simulated_recording(random, FrameKind::stereo, 20, 300, [&](Frame& frame) {
    add_errors(random, frame);
    for (Match& match : frame.matches) {
      if (random.chance(0.12)) shift(match, random.uniform(-60, 60), random.uniform(-60, 60));
    }
  });
  const Evaluation evaluation = evaluated(frames, {60});
  EXPECT_NEAR(evaluation.inliers / evaluation.matches, 0.88, 0.03);
  EXPECT_NEAR(evaluation.row("random", 60)->wrong.value, 0.12, 0.03);
  EXPECT_LT(evaluation.row("random_gated", 60)->wrong.value, 0.01);
  EXPECT_LT(evaluation.row("md", 60)->wrong.value, 0.01);
  EXPECT_GT(evaluation.row("md_ungated", 60)->wrong.value, 0.05);
  EXPECT_LT(evaluation.row("aligned", 0)->wrong.value, 0.01);
  for (const std::size_t part : {0U, 1U}) {
    EXPECT_LT(evaluation.row("md", 60)->costs[part].growth.value,
              evaluation.row("md_ungated", 60)->costs[part].growth.value);
  }
}

// One match is wrong; or numbers are those of a tracker in float32 that records without noise.
TEST(EvaluationOfErrors, that_are_rounding_cannot_tell) {
  TracedRandom random;
  const auto spoil = [](Frame& frame) { frame.matches[0].v += 100; };
  const auto round = [](Frame& frame) {
    for (Match& m : frame.matches) {
      for (double* const number : {m.point, m.point + 1, m.point + 2, &m.u, &m.v, &m.u_right, &m.depth}) {
        *number = static_cast<float>(*number);
      }
    }
  };
  const auto expect_cannot_tell = [](const std::vector<Frame>& frames) {
    const std::string text = to_text(evaluated(frames, {20, 40}));
    expect_begins(text, "These frames cannot tell: their residuals are rounding errors");
    EXPECT_EQ(text.find('|'), std::string::npos) << "tables of rounding errors";
  };
  for (const FrameKind kind : frame_kinds) {
    SCOPED_TRACE(to_string(kind));
    expect_cannot_tell(simulated_recording(random, kind, 12, 60, spoil));
    if (kind == FrameKind::fisheye || kind == FrameKind::rig) continue;
    expect_cannot_tell(simulated_recording(random, kind, 12, 60, round));
  }
}

Statistic within_tenth(double value) { return {value, {0.9 * value, 1.1 * value}}; }

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

void expect_begins(const Verdict& verdict, const std::string& text) { expect_begins(verdict.text, text); }

void expect_advice(const Verdict& verdict, const std::string& text) {
  std::string all;
  for (const std::string& sentence : verdict.advice) all += sentence + "\n";
  EXPECT_NE(all.find(text), std::string::npos) << all;
}

TEST(Verdict, names_the_parts_in_which_a_selection_is_better_or_worse_than_random) {
  const struct {
    double m_of_random, rad_of_random;
    const char *text, *recommended;
  } cases[] = {
      {0.5, 0.6, "pays: with 100 of some 300 inliers the standard deviation", "md"},
      {0.5, 1.3, "pays in translation, but in rotation it is worse than random: with 100", "md"},
      {1, 0.5, "pays in rotation, but in translation these frames show no difference from random: with 100", "md"},
      {1.3, 1.3, "does not help here: with 100", "aligned"},
      {1.3, 1, "does not help here, and is worse than random in translation: with 100", "aligned"}};
  for (const auto& [m_of_random, rad_of_random, text, recommended] : cases) {
    // At the usual budget alone.
    const Verdict verdict = verdict_of(evaluation_of({row_of("md", 100, 0.1, 0.2, m_of_random, rad_of_random)}));
    expect_begins(verdict, std::string("Max-logDet ") + text);
    EXPECT_EQ(verdict.recommended, recommended);
  }
  expect_begins(verdict_of(evaluation_of({row_of("md", 100, 0.1, 0.2, 1, 1)})),
                "These frames cannot tell whether Max-logDet helps: with 100");
}

TEST(Verdict, advises_the_smallest_budget_for_each_growth_and_no_selection_or_pose_beyond) {
  Verdict verdict = verdict_of(
      evaluation_of({row_of("md", 60, 0.19, 0.3), row_of("md", 100, 0.12, 0.19, 0.5, 1.02),
                     row_of("md", 150, 0.04, 0.08), row_of("md", 200, 0.03, 0.06), row_of("md", 230, 0.01, 0.01)}));
  expect_begins(verdict, "Max-logDet pays");
  expect_advice(verdict, "at most 5 %, 230; at most 10 %, 150; at most 20 %, 100 (no better than random in rotation).");
  expect_advice(verdict,
                "For the pose alone, do not select, take pose(): its standard deviation grows by 2.0 % (1.8 to");
  verdict = verdict_of(evaluation_of({row_of("md", 100, 0.4, 0.3), row_of("md", 200, 0.21, 0.1)}));
  expect_begins(verdict,
                "Do not select, take pose(): no budget that was tried keeps the growth of the standard deviation "
                "within 20 %. Max-logDet is better than random: with 100");
  EXPECT_EQ(verdict.recommended, "aligned");
  expect_advice(verdict, "For later steps, use all inliers, or try larger --budgets.");
  Evaluation evaluation = evaluation_of({row_of("md", 100, 0.1, 0.1)});
  evaluation.rows.back() = row_of("aligned", 290, 0.02, 0.4);
  expect_advice(verdict_of(evaluation), "For the pose alone, optimise with all inliers, not pose(), whose");
  evaluation.rows[0] = row_of("md", 100, 0.4, 0.4);
  expect_begins(verdict_of(evaluation), "Do not select, optimise with all inliers: no budget that was tried keeps");
}

// pose() is judged by true poses where they are known, or else a way to know them is named.
TEST(Verdict, says_what_true_poses_tell) {
  Evaluation evaluation = evaluation_of({row_of("md", 100, 0.4, 0.4)});
  EvaluationRow& aligned = evaluation.rows.back();
  aligned = row_of("aligned", 290, 1.5, 0.1);
  const Verdict unknown = verdict_of(evaluation);
  expect_begins(unknown, "Do not select, optimise with all inliers");
  expect_advice(unknown, "Record the covariances of map points, where these are uncertain. True poses would tell");
  aligned.costs[0].true_growth = {-0.05, {-0.1, 0.02}};
  aligned.costs[1].true_growth = within_tenth(0.01);
  aligned.steps = 9;
  EXPECT_EQ(verdict_of(evaluation).advice, unknown.advice) << "too few";
  aligned.steps = 49;
  evaluation.rows[0].costs[0].true_growth = within_tenth(0.3);
  evaluation.rows[0].costs[1].true_growth = within_tenth(0.2);
  evaluation.rows[0].steps = 49;
  const Verdict near = verdict_of(evaluation);
  expect_begins(near, "Do not select, take pose()");
  EXPECT_NE(near.text.find("Against the true poses the error grows by 30 % (27 to 33) in translation"),
            std::string::npos);
  expect_advice(near,
                "take pose(): its standard deviation grows by 150 % (135 to 165) in translation and 10 % (9.0 to 11)");
  expect_advice(near, "Against the true poses the error grows by -5.0 % (-10 to 2.0) in translation and 1.0 % (0.9 to");
  aligned.costs[0].true_growth = within_tenth(0.5);
  expect_begins(verdict_of(evaluation), "Do not select, optimise with all inliers");
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
