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
  double log_ratios = 0;        // sum of log(measured / predicted), of squared deviations

  void add(const sim::Estimate& estimate, double expected) {
    ++values;
    if (!contains(estimate.interval, expected)) ++outside;
    if (!contains(widened(estimate.interval, estimate.value, 2), expected)) ++far_outside;
  }
};

// E|x_S - x_all|^2 over the variance of x_all, from the growth of the standard deviation.
double squared(double growth) { return (1 + growth) * (1 + growth) - 1; }
double ratio(const sim::Cost& cost) { return squared(cost.growth.value) / squared(cost.predicted); }

void add_growth(const Evaluation& evaluation, Tally& tally) {
  for (const EvaluationRow& row : evaluation.rows) {
    if (!row.has_budget) continue;
    for (const sim::Cost& cost : row.costs) {
      tally.add(cost.growth, cost.predicted);
      tally.log_ratios += std::log(ratio(cost));
      EXPECT_NEAR(ratio(cost), 1, 0.4) << row.selector << ' ' << row.budget;
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
  EXPECT_NEAR(evaluation.inliers, 0.995 * 200, 0.8) << "the limits are quantiles, of a scale that scatters";
  Tally deviations;
  add_growth(evaluation, deviations);
  EXPECT_EQ(deviations.values, 4 * 3 * 2U);
  EXPECT_LE(deviations.outside, deviations.values / 2)
      << "1 in 20, but all of the translation, or rotation, share frames";
  EXPECT_LE(deviations.far_outside, 1U) << "of 24, by resamples of eight blocks";
  EXPECT_NEAR(deviations.log_ratios / static_cast<double>(deviations.values), 0, 0.12);

  Tally noise;
  for (std::size_t d = 0; d < sim::leverage_classes; ++d) {
    noise.add(evaluation.chi2_by_leverage[d], 1);
    EXPECT_NEAR(evaluation.chi2_by_leverage[d].value, 1, 0.1);
  }
  noise.add(evaluation.cell_correlation, 0);
  EXPECT_LE(noise.outside, noise.values / 3) << "they share their frames, too";
  EXPECT_EQ(noise.far_outside, 0U);
  EXPECT_NEAR(evaluation.cell_correlation.value, 0, 0.02);
  EXPECT_FALSE(verdict_of(evaluation).shares_errors);
  for (const sim::Cost& cost : evaluation.row("aligned", 0)->costs) EXPECT_LT(cost.growth.value, 0.1);
}

INSTANTIATE_TEST_SUITE_P(EveryKindOfFrame, EvaluationOf, ::testing::ValuesIn(frame_kinds),
                         [](const auto& of) { return to_string(of.param); });

// The deviations and the pose of all inliers are measured on the same scale.
TEST(EvaluationOfErrors, smaller_or_larger_than_modelled_change_chi2_and_not_the_growth) {
  TracedRandom random;
  const std::vector<Frame> frames = independent_recording(random, FrameKind::stereo, 60);
  const auto model = [&](double sigmas) {
    std::vector<Frame> modelled = frames;
    for (Frame& frame : modelled) {
      for (Match& match : frame.matches) match.inv_sigma2 /= sigmas * sigmas;
    }
    return evaluation_of(modelled, short_options());
  };
  const Evaluation expected = model(1);
  for (const double sigmas : {0.4, 0.5, 2.5}) {
    SCOPED_TRACE(sigmas);
    const Evaluation evaluation = model(sigmas);
    EXPECT_NEAR(evaluation.chi2 * sigmas * sigmas, 1, 0.1);
    for (const sim::Estimate& chi2 : evaluation.chi2_by_leverage) EXPECT_NEAR(chi2.value * sigmas * sigmas, 1, 0.15);
    EXPECT_NEAR(evaluation.cell_correlation.value, 0, 0.03);
    ASSERT_EQ(evaluation.rows.size(), expected.rows.size());
    for (std::size_t i = 0; i < expected.rows.size(); ++i) {
      for (const std::size_t part : {0U, 1U}) {
        const double growth = evaluation.rows[i].costs[part].growth.value;
        EXPECT_NEAR((1 + growth) / (1 + expected.rows[i].costs[part].growth.value), 1, 0.12)
            << "Huber's loss is another";
      }
    }
  }
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
    const sim::Estimate& found = evaluation.cell_correlation;
    // The pose takes 6 of the 96 shared errors of a frame, which is not corrected: some 6 % of them. The rest is what
    // 60 frames leave of chance, other on each compiler, which may order the draws of an expression as it likes.
    EXPECT_NEAR(found.value, 0.94 * correlation, 0.15 * correlation);
    EXPECT_GT(found.interval.low, 0);
    EXPECT_LT(found.interval.high - found.interval.low, 0.5 * correlation);
    if (tau < 0.6) continue;
    EXPECT_TRUE(verdict_of(evaluation).shares_errors);
    EXPECT_NE(verdict_of(evaluation).text.find("share errors"), std::string::npos);
    const sim::Cost& translation = evaluation.row("md", 30)->costs[0];
    EXPECT_GT(translation.growth.interval.low, translation.predicted);
  }
}

// Matches of a frame without errors by their leverage tr(H C H^T), lowest first.
std::vector<std::uint32_t> by_leverage(const Frame& frame) {
  std::vector<sim::LinearizedMatch> linearized(frame.matches.size());
  Matrix6 information = Matrix6::Zero();
  const auto whitened = [&](std::size_t i) {
    const Eigen::MatrixXd H = linearized[i].H_x.topRows(linearized[i].rows);
    return Eigen::MatrixXd(H * std::sqrt(frame.matches[i].inv_sigma2));
  };
  for (std::size_t i = 0; i < linearized.size(); ++i) {
    EXPECT_TRUE(linearize(frame.camera, sim::pose_of(frame.T_cw_prior), frame.matches[i], true, linearized[i]));
    information += gram(whitened(i));
  }
  const Matrix6 covariance = inverse(information);
  std::vector<std::pair<double, std::uint32_t>> leverages;
  for (std::uint32_t i = 0; i < linearized.size(); ++i) {
    leverages.emplace_back(product(covariance, gram(whitened(i))).trace(), i);
  }
  std::sort(leverages.begin(), leverages.end());
  std::vector<std::uint32_t> order;
  for (const auto& [leverage, i] : leverages) order.push_back(i);
  return order;
}

TEST(EvaluationOfErrors, that_grow_with_leverage_raise_the_chi2_of_higher_deciles) {
  TracedRandom random;
  const auto variance = [](std::size_t decile) { return 0.2 + 0.12 * static_cast<double>(decile); };
  const auto add = [&](Frame& frame) {
    const std::vector<std::uint32_t> order = by_leverage(frame);
    Frame alone;
    alone.camera = frame.camera;
    for (std::size_t place = 0; place < order.size(); ++place) {
      alone.matches = {frame.matches[order[place]]};
      add_errors(random, alone, std::sqrt(variance(10 * place / order.size())));
      frame.matches[order[place]] = alone.matches[0];
    }
  };
  const Evaluation evaluation =
      evaluation_of(simulated_recording(random, FrameKind::stereo, 60, 300, add), short_options());
  for (std::size_t d = 0; d < sim::leverage_classes; ++d) {
    EXPECT_NEAR(evaluation.chi2_by_leverage[d].value, variance(d), 0.25) << d << ": limits hide a part of the largest";
    if (d >= 2) {
      EXPECT_GT(evaluation.chi2_by_leverage[d].interval.low, evaluation.chi2_by_leverage[d - 2].interval.high) << d;
    }
  }
  EXPECT_NEAR(evaluation.cell_correlation.value, 0, 0.03);
}

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
  options.budgets = {30, 60, 100, 150, 200};
  options.repeats = 4;
  const Evaluation evaluation = sim::evaluate({frames}, options, 2);
  for (const std::size_t budget : options.budgets) {
    for (const std::size_t part : {0U, 1U}) {
      const sim::Cost& md = evaluation.row("md", budget)->costs[part];
      EXPECT_LT(md.of_random.interval.high, 1);
      EXPECT_LT(md.of_random.value, 0.8);
      EXPECT_TRUE(contains(md.of_random.interval, md.of_random.value));
      EXPECT_EQ(evaluation.row("random_gated", budget)->costs[part].of_random.value, 1);
      EXPECT_NEAR(evaluation.row("random", budget)->costs[part].of_random.value, 1.1, 0.3);
    }
  }
  // A random selection, drawn here.
  const EvaluationRow& own = *evaluation.row("own", 100);
  EXPECT_EQ(own.budget, 100U);
  for (const std::size_t part : {0U, 1U}) {
    EXPECT_TRUE(contains(widened(own.costs[part].growth.interval, own.costs[part].growth.value, 1.5),
                         evaluation.row("random_gated", 100)->costs[part].growth.value));
  }
  const sim::Verdict verdict = verdict_of(evaluation);
  EXPECT_EQ(verdict.text.rfind("Max-logDet pays: with 100 of some 29", 0), 0U) << verdict.text;
  EXPECT_EQ(verdict.recommended, "md");
}

// Far off, with any direction.
void spoil(Random& random, Frame& frame, double share) {
  for (Match& match : frame.matches) {
    if (random.chance(share)) shift(match, random.uniform(-60, 60), random.uniform(-60, 60));
  }
}

TEST(EvaluationOfErrors, of_wrong_matches_show_what_the_gate_brings) {
  TracedRandom random;
  const auto frames = simulated_recording(random, FrameKind::stereo, 20, 300, [&](Frame& frame) {
    add_errors(random, frame);
    spoil(random, frame, 0.12);
  });
  EvaluationOptions options;
  options.budgets = {60};
  const Evaluation evaluation = sim::evaluate({frames}, options, 2);
  EXPECT_NEAR(evaluation.inliers / evaluation.matches, 0.88, 0.03);
  EXPECT_NEAR(evaluation.row("random", 60)->wrong.value, 0.12, 0.03);
  EXPECT_LT(evaluation.row("random_gated", 60)->wrong.value, 0.01);
  EXPECT_LT(evaluation.row("md", 60)->wrong.value, 0.01);
  EXPECT_GT(evaluation.row("md_ungated", 60)->wrong.value, 0.05);
  EXPECT_LT(evaluation.row("aligned", 0)->wrong.value, 0.01);
  for (const std::size_t part : {0U, 1U}) {
    EXPECT_LT(evaluation.row("aligned", 0)->costs[part].growth.value, 0.1);
    EXPECT_LT(evaluation.row("md", 60)->costs[part].growth.value,
              evaluation.row("md_ungated", 60)->costs[part].growth.value);
  }
}

}  // namespace
}  // namespace maxlogdet::test
