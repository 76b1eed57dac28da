// SPDX-License-Identifier: MIT
// What an evaluation says of frames whose errors are known.
#include "bench/does_it_help/evaluation.hpp"

#include "bench/does_it_help/verdict.hpp"
#include "tests/bench/simulated_evaluation.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/traced_random.hpp"

namespace maxlogdet::test {
namespace {

// How many of an evaluation's numbers are where the model has them.
struct Tally {
  std::size_t values = 0;
  std::size_t outside = 0;      // of their interval
  std::size_t far_outside = 0;  // of twice the interval
  double log_ratios = 0;        // sum of log(measured / predicted)

  void add(double value, const Interval& interval, double expected) {
    ++values;
    if (!contains(interval, expected)) ++outside;
    if (!contains(widened(interval, value, 2), expected)) ++far_outside;
  }
};

void add_deviations(const Evaluation& evaluation, Tally& tally) {
  for (const EvaluationRow& row : evaluation.rows) {
    for (const sim::DeviationSummary* const part : {&row.translation, &row.rotation}) {
      tally.add(part->median, part->of_median, part->predicted);
      tally.log_ratios += std::log(part->median / part->predicted);
      EXPECT_NEAR(part->p90 / part->predicted_p90, 1, 0.35) << row.selector << ' ' << row.budget;
      EXPECT_NEAR(part->median / part->predicted, 1, 0.3) << row.selector << ' ' << row.budget;
    }
  }
}

std::vector<Frame> independent_recording(Random& random, FrameKind kind, std::size_t frames, double sigmas = 1) {
  return simulated_recording(random, kind, frames, 200, [&](Frame& frame) { add_errors(random, frame, sigmas); });
}

class EvaluationOf : public ::testing::TestWithParam<FrameKind> {};

TEST_P(EvaluationOf, independent_errors_of_the_modelled_size_has_ratios_of_one_and_no_correlation) {
  TracedRandom random;
  const Evaluation evaluation = evaluation_of(independent_recording(random, GetParam(), 80), short_options());
  EXPECT_EQ(evaluation.frames, 80U);
  EXPECT_EQ(evaluation.unusable, 0U);
  EXPECT_EQ(evaluation.matches, 200);
  EXPECT_GT(evaluation.inliers, 199.5) << "the gate hides no noise";
  Tally deviations;
  add_deviations(evaluation, deviations);
  EXPECT_EQ(deviations.values, 4 * 3 * 2U);
  EXPECT_LE(deviations.outside, deviations.values / 4) << "some 1 in 20, but they depend on one another";
  EXPECT_LE(deviations.far_outside, 1U) << "of 24, by resamples of eight blocks; 600 frames are held to 6 % below";
  EXPECT_NEAR(deviations.log_ratios / static_cast<double>(deviations.values), 0, 0.06);

  Tally noise;
  for (std::size_t d = 0; d < sim::leverage_classes; ++d) {
    noise.add(evaluation.chi2_by_leverage[d], evaluation.of_chi2[d], 1);
    EXPECT_NEAR(evaluation.chi2_by_leverage[d], 1, 0.1);
  }
  noise.add(evaluation.cell_correlation.value, evaluation.cell_correlation.interval, 0);
  noise.add(evaluation.cell_correlation_selected.value, evaluation.cell_correlation_selected.interval, 0);
  EXPECT_LE(noise.outside, noise.values / 3) << "they share their frames, too";
  EXPECT_EQ(noise.far_outside, 0U);
  EXPECT_NEAR(evaluation.cell_correlation.value, 0, 0.02);
  EXPECT_NEAR(evaluation.cell_correlation_selected.value, 0, 0.04);
  EXPECT_FALSE(verdict_of(evaluation).shares_errors);
}

INSTANTIATE_TEST_SUITE_P(EveryKindOfFrame, EvaluationOf, ::testing::ValuesIn(frame_kinds),
                         [](const auto& of) { return to_string(of.param); });

TEST(EvaluationOfErrors, twice_as_large_as_modelled_have_a_chi2_of_four_and_no_correlation) {
  TracedRandom random;
  // Small, so that neither the gate nor Huber's loss is in the way: half of 0.4 deviations is modelled.
  std::vector<Frame> frames = independent_recording(random, FrameKind::stereo, 60, 0.4);
  const auto model = [&](double sigmas) {
    std::vector<Frame> modelled = frames;
    for (Frame& frame : modelled) {
      for (Match& match : frame.matches) match.inv_sigma2 /= sigmas * sigmas;
    }
    return evaluation_of(modelled, short_options());
  };
  const Evaluation evaluation = model(1);
  for (const double chi2 : evaluation.chi2_by_leverage) EXPECT_NEAR(chi2, 0.4 * 0.4, 0.1 * 0.4 * 0.4);
  for (const EvaluationRow& row : evaluation.rows) {
    EXPECT_NEAR(row.translation.median / row.translation.predicted, 0.4, 0.1);
    EXPECT_NEAR(row.rotation.median / row.rotation.predicted, 0.4, 0.1);
  }
  EXPECT_NEAR(evaluation.cell_correlation.value, 0, 0.03) << "whatever the size of the errors";
  // With outliers beyond the gate: 24 of chi2 are 6 of errors twice as large, of which 5 % are larger with two rows.
  const Evaluation of_double = model(0.2);
  for (const double chi2 : of_double.chi2_by_leverage) EXPECT_NEAR(chi2, 3.5, 0.5);
  EXPECT_NEAR(of_double.cell_correlation.value, 0, 0.03);
}

// Matches of equal noise, sigma = 1 px.
std::vector<Frame> sharing_recording(Random& random, std::size_t frames, double tau, double scale = 1) {
  const auto add = [&](Frame& frame) {
    add_field(frame, sim::noise_grid, random_field(random, scale * tau, sim::noise_grid.cells()));
    add_errors(random, frame, scale);
  };
  return simulated_recording(random, FrameKind::stereo, frames, 300, add, 1);
}

TEST(EvaluationOfErrors, that_cells_share_are_found_of_their_true_size) {
  TracedRandom random;
  for (const double tau : {0.3, 0.6, 1.0}) {
    SCOPED_TRACE(tau);
    // Scaled down, so that the gate takes none of the larger errors away.
    const double scale = 1 / std::sqrt(1 + tau * tau);
    const Evaluation evaluation = evaluation_of(sharing_recording(random, 60, tau, scale), short_options());
    const double correlation = tau * tau / (1 + tau * tau);
    const sim::Correlation& found = evaluation.cell_correlation;
    // The pose takes 6 of the 96 shared errors of a frame, which is not corrected: some 6 % of them. The rest is what
    // 60 frames leave of chance, other on each compiler, which may order the draws of an expression as it likes.
    EXPECT_NEAR(found.value, 0.94 * correlation, 0.15 * correlation);
    EXPECT_GT(found.interval.low, 0);
    EXPECT_LT(found.interval.high - found.interval.low, 0.5 * correlation);
    const sim::Correlation& selected = evaluation.cell_correlation_selected;
    EXPECT_NEAR(selected.value, correlation, 0.3 * correlation);
    EXPECT_GT(selected.interval.low, 0);
    if (tau < 0.6) continue;
    EXPECT_TRUE(verdict_of(evaluation).shares_errors);
    EXPECT_NE(verdict_of(evaluation).text.find("share errors"), std::string::npos);
    const EvaluationRow& md = *evaluation.row("md", 30);
    EXPECT_GT(md.translation.median / md.translation.predicted, 1.1);
    EXPECT_GT(md.translation.of_median.low, md.translation.predicted);
  }
}

TEST(EvaluationOfErrors, that_stay_at_a_place_of_the_image_are_told_from_those_that_do_not) {
  TracedRandom random;
  constexpr double tau = 0.7;
  const auto field = random_field(random, tau, sim::noise_grid.cells());
  const auto add = [&](Frame& frame) {
    add_field(frame, sim::noise_grid, field);
    add_errors(random, frame, 0.7);
  };
  const Evaluation fixed =
      evaluation_of(simulated_recording(random, FrameKind::stereo, 60, 300, add, 1), short_options());
  double size = 0;
  for (const Eigen::Vector2d& of_cell : field) size += of_cell.squaredNorm() / 2;
  size /= static_cast<double>(field.size());
  const double expected = size / (size + 0.7 * 0.7);
  EXPECT_NEAR(fixed.cell_correlation.value, expected, 0.15 * expected);
  EXPECT_NEAR(fixed.static_correlation, expected, 0.15 * expected);
  const Evaluation redrawn = evaluation_of(sharing_recording(random, 60, tau), short_options());
  EXPECT_GT(redrawn.cell_correlation.value, 0.2);
  EXPECT_NEAR(redrawn.static_correlation, 0, 0.03);
  EXPECT_TRUE(std::isnan(evaluation_of(sharing_recording(random, 39, tau), short_options()).static_correlation))
      << "too short";
}

// A random selection, drawn here and not by the contestant that it is compared with, is worth its own number.
TEST(EvaluationOfErrors, independent_ones_make_selection_pay) {
  TracedRandom random;
  const auto frames = simulated_recording(random, FrameKind::stereo, 40, 300, [&](Frame& frame) {
    add_errors(random, frame);
    frame.has_selection = true;
    std::vector<std::uint32_t> all = all_matches(frame);
    for (std::size_t i = 0; i < 100; ++i) {
      std::swap(all[i], all[i + random.index(all.size() - i)]);
      frame.matches[all[i]].is_selected = true;
    }
  });
  EvaluationOptions options;
  options.repeats = 4;
  const Evaluation evaluation = sim::evaluate({frames}, options, 2);
  for (const std::size_t budget : options.budgets) {
    const EvaluationRow& md = *evaluation.row("md", budget);
    EXPECT_EQ(md.frames, 40U);
    EXPECT_GT(md.worth_random->matches, 1.2 * static_cast<double>(budget));
    EXPECT_GT(md.worth_random->interval.low, static_cast<double>(budget));
    EXPECT_LE(md.worth_random->matches, 300);
    EXPECT_TRUE(contains(md.worth_random->interval, md.worth_random->matches));
    // What random and bucket matches are worth needs no row: it is their budget.
    EXPECT_FALSE(evaluation.row("random", budget)->worth_random);
    EXPECT_FALSE(evaluation.row("bucket", budget)->worth_random);
  }
  const EvaluationRow& own = *evaluation.row("own", 100);
  EXPECT_EQ(own.frames, 40U);
  EXPECT_NEAR(own.worth_random->matches, 100, 12);
  EXPECT_TRUE(contains(own.worth_random->interval, 100));
  const sim::Verdict verdict = verdict_of(evaluation);
  EXPECT_EQ(verdict.text.rfind("Max-logDet pays: 100 of your matches", 0), 0U) << verdict.text;
  EXPECT_EQ(verdict.recommended, "md");
}

}  // namespace
}  // namespace maxlogdet::test
