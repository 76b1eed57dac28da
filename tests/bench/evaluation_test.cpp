// SPDX-License-Identifier: MIT
// What an evaluation computes of frames: deviations against what covariances predict, noise against plain double loops,
// growth and steps against poses that are optimised here, resamples. verdict_test.cpp has what it concludes.
#include "cli/evaluation.hpp"

#include "bench/world/projection.hpp"
#include "cli/report.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/support.hpp"

#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

using sim::Choice;
using sim::Evaluation;
using sim::EvaluationOptions;
using sim::EvaluationRow;
using sim::FrameCounts;
using sim::FrameEvaluation;
using sim::Parts;
using sim::PoseEstimate;
using sim::PoseOptions;
using sim::Vector6;

std::vector<Frame> recording(Random& random, FrameKind kind, std::size_t frames, std::size_t n) {
  return simulated_recording(random, kind, frames, n, [&](Frame& frame) { add_errors(random, frame); });
}

EvaluationOptions small_options(std::vector<std::size_t> budgets = {20, 40}) {
  EvaluationOptions options;
  options.budgets = std::move(budgets);
  options.repeats = 2;
  return options;
}

Parts squares_of(const Vector6& xi) { return {xi.head<3>().squaredNorm(), xi.tail<3>().squaredNorm()}; }
Parts traces_of(const Matrix6& covariance) {
  return {covariance.topLeftCorner<3, 3>().trace(), covariance.bottomRightCorner<3, 3>().trace()};
}

// Cov(x_S - x_all) = Cov(x_S) - Cov(x_all), against many draws of one frame's noise; of a stereo camera its map has
// errors, too.
class PredictedDeviation : public ::testing::TestWithParam<FrameKind> {};

// The mean of n outer products, whitened by what is predicted, is I, with deviations of sqrt(1 / n), on the diagonal
// sqrt(2 / n). Huber's loss adds 1 %.
TEST_P(PredictedDeviation, has_the_covariance_of_many_draws) {
  TracedRandom random;
  Frame exact = simulated_frame(random, GetParam(), 150);
  EvaluationOptions options = small_options({40});
  options.contestants = {{"md", Choice::md, false}};
  BlockOptions of_blocks;
  of_blocks.depth_cue = exact.camera.depth_cue();
  if (exact.camera.depth_sigma > 0) of_blocks.depth_sigma = exact.camera.depth_sigma;
  std::vector<Eigen::Matrix3d> roots;
  std::vector<sim::Whitening> whitenings;
  if (GetParam() == FrameKind::stereo) {
    options.weighting = of_blocks.weighting = Weighting::measurement_and_map;
    for (std::size_t i = 0; i < exact.matches.size(); ++i) {
      const Eigen::Matrix3d covariance = random_covariance(random, 0.1, 1e-5);
      roots.emplace_back(cholesky(covariance));
      set_covariance(exact, i, covariance);
    }
    whitenings = whitenings_of(exact, pose_of(exact), true, 0);
  }
  BlockStore blocks(exact.matches.size());
  build_blocks(exact, of_blocks, blocks);
  const auto covariance_with = [&](const Subset& subset) {
    return optimize_pose(exact.camera, exact.matches, subset, pose_of(exact), precise(), whitenings).covariance();
  };
  const Matrix6 predicted =
      covariance_with(select_indices(blocks, with_budget(40))) - covariance_with(all_matches(exact));
  const Eigen::MatrixXd factor = cholesky(predicted);
  const std::size_t n = trials(1500);
  Matrix6 mean = Matrix6::Zero();
  Vector6 sum = Vector6::Zero();
  Parts mean_predicted = Parts::Zero();
  for (std::size_t trial = 0; trial < n; ++trial) {
    Frame frame = exact;
    add_errors(random, frame);
    for (std::size_t i = 0; i < roots.size(); ++i) {
      const Eigen::Vector3d draws(normal(random), normal(random), normal(random));
      Eigen::Map<Eigen::Vector3d>(frame.matches[i].point) += roots[i] * draws;
    }
    const FrameEvaluation evaluated = evaluate_frame(frame, trial, options);
    ASSERT_TRUE(evaluated.is_usable);
    const sim::Deviation& deviation = evaluated.deviations.at(0).at(0).at(0);
    const Vector6 error = solve_lower(factor, deviation.xi);
    mean += error * error.transpose() / static_cast<double>(n);
    sum += error / static_cast<double>(n);
    mean_predicted += deviation.predicted / static_cast<double>(n);
  }
  const double tolerance = 5 * std::sqrt(2 / static_cast<double>(n)) + 20 / static_cast<double>(n) + 0.02;
  EXPECT_LT(largest_difference(mean, Matrix6::Identity()), tolerance);
  EXPECT_NEAR(mean.trace() / 6, 1, 5 * std::sqrt(2 / (6 * static_cast<double>(n))) + 0.03);
  EXPECT_LT(sum.norm(), 6 * std::sqrt(6 / static_cast<double>(n))) << "no bias";
  for (const int part : {0, 1}) EXPECT_NEAR(mean_predicted(part) / traces_of(predicted)(part), 1, 0.1);
}

INSTANTIATE_TEST_SUITE_P(EveryKindOfFrame, PredictedDeviation, ::testing::ValuesIn(frame_kinds),
                         [](const auto& of) { return to_string(of.param); });

// Whitened residuals and Jacobians at the pose of all, by plain variances.
struct Whitened {
  Eigen::VectorXd r;
  Eigen::MatrixXd H;
};

Whitened whitened(const Frame& frame, const Pose& T_cw, const Match& match) {
  sim::LinearizedMatch at;
  EXPECT_TRUE(linearize(frame.camera, T_cw, match, true, at));
  Eigen::VectorXd deviations = Eigen::VectorXd::Constant(at.rows, 1 / std::sqrt(match.inv_sigma2));
  if (match.depth > 0) deviations(2) = frame.camera.depth_sigma;
  const Eigen::MatrixXd H = deviations.cwiseInverse().asDiagonal() * at.H_x.topRows(at.rows);
  return {at.residual.head(at.rows).cwiseQuotient(deviations), H};
}

TEST(FrameNoise, is_the_sum_of_plain_double_loops_over_cells_and_deciles_of_leverage) {
  for (const FrameKind kind : frame_kinds) {
    TracedRandom random(static_cast<std::uint64_t>(kind));
    SCOPED_TRACE(to_string(kind));
    Frame frame = simulated_frame(random, kind, 123);
    add_errors(random, frame);
    std::vector<sim::Whitening> whitenings;
    for (const Match& match : frame.matches) whitenings.push_back(measurement_whitening(frame.camera, match));
    const Subset all = all_matches(frame);
    const PoseEstimate pose = optimize_pose(frame.camera, frame.matches, all, pose_of(frame), precise());
    const Eigen::MatrixXd C = inverse(pose.information);
    const auto cell_of = [&](const Match& match) {
      const double column = std::clamp(std::floor(match.u / frame.width * 8), 0.0, 7.0);
      return std::array<double, 3>{column, std::clamp(std::floor(match.v / frame.height * 6), 0.0, 5.0),
                                   static_cast<double>(match.camera_id)};
    };
    std::vector<Whitened> at;
    std::vector<std::pair<double, std::size_t>> by_leverage;
    sim::PairSums pairs;
    for (const Match& match : frame.matches) at.push_back(whitened(frame, pose.T_cw, match));
    for (std::size_t i = 0; i < at.size(); ++i) {
      by_leverage.emplace_back(product(at[i].H, product(C, at[i].H.transpose())).trace(), i);
      for (std::size_t j = 0; j <= i; ++j) {
        if (cell_of(frame.matches[i]) != cell_of(frame.matches[j])) continue;
        const double product_of_both = at[i].r.head<2>().dot(at[j].r.head<2>());
        const double fitted = product(at[i].H.topRows(2), product(C, at[j].H.topRows(2).transpose())).trace();
        (i == j ? pairs.matches : pairs.pairs) += 1;
        (i == j ? pairs.squares : pairs.products) += product_of_both;
        (i == j ? pairs.fitted_self : pairs.fitted) += fitted;
      }
    }
    std::sort(by_leverage.begin(), by_leverage.end());
    std::array<double, sim::leverage_classes> chi2{}, freedom{};
    for (std::size_t i = 0; i < at.size(); ++i) {
      const auto& [leverage, which] = by_leverage[i];
      chi2[10 * i / at.size()] += at[which].r.squaredNorm();
      freedom[10 * i / at.size()] += static_cast<double>(at[which].r.size()) - leverage;
    }
    const sim::FrameNoise noise = noise_of(frame, pose, all, whitenings);
    EXPECT_GT(pairs.pairs, 0);
    EXPECT_EQ(noise.pairs.pairs, pairs.pairs);
    EXPECT_EQ(noise.pairs.matches, pairs.matches);
    EXPECT_NEAR(noise.pairs.products, pairs.products, 1e-9 * pairs.squares);
    EXPECT_NEAR(noise.pairs.squares, pairs.squares, 1e-9 * pairs.squares);
    EXPECT_NEAR(noise.pairs.fitted, pairs.fitted, 1e-8);
    EXPECT_NEAR(noise.pairs.fitted_self, pairs.fitted_self, 1e-8);
    for (std::size_t d = 0; d < sim::leverage_classes; ++d) {
      EXPECT_NEAR(noise.chi2[d], chi2[d], 1e-7);
      EXPECT_NEAR(noise.freedom[d], freedom[d], 1e-8);
    }
  }
}

TEST(FrameNoise, correlation_is_that_of_products_freed_from_the_fit) {
  // Nothing fitted: the mean product of a pair, of two entries each, over their variance.
  EXPECT_DOUBLE_EQ(sim::correlation_of({12, 0, 20, 80, 0, 10}), 12.0 / (2 * 20) / (80.0 / 20));
  // Independent noise: products are what the fit makes of it, -fitted times the variance.
  EXPECT_NEAR(sim::correlation_of({-3 * 1.5, 1.5, 20, 3 * (20 - 4), 4, 10}), 0, 1e-15);
  EXPECT_TRUE(std::isnan(sim::correlation_of({0, 0, 0, 10, 1, 5}))) << "no pairs";
}

TEST(EvaluationOfFrames, leaves_out_and_counts_those_without_a_pose) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 12, 60);
  const Evaluation before = sim::evaluate({{frames.begin(), frames.begin() + 9}}, small_options(), 1);
  frames[9].matches.resize(9);                                       // too few
  for (Match& match : frames[10].matches) match.u = 5000 - match.u;  // they agree with no pose
  const Pose turned = Pose(Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY()));
  frames[11].T_cw_prior = sim::to_rows(turned * pose_of(frames[11]));  // all are behind the camera
  const Evaluation after = sim::evaluate({frames}, small_options(), 1);
  EXPECT_EQ(after.frames, 12U);
  EXPECT_EQ(after.unusable, 3U);
  EXPECT_EQ(after.matches, before.matches);
  EXPECT_EQ(after.inliers, before.inliers);
  EXPECT_EQ(after.chi2, before.chi2);
  EXPECT_EQ(after.cell_correlation.value, before.cell_correlation.value);
  ASSERT_EQ(after.rows.size(), before.rows.size());
  for (std::size_t i = 0; i < after.rows.size(); ++i) {
    EXPECT_EQ(after.rows[i].frames, 9U);
    for (const std::size_t part : {0U, 1U}) {
      EXPECT_EQ(after.rows[i].costs[part].growth.value, before.rows[i].costs[part].growth.value);
      EXPECT_EQ(after.rows[i].costs[part].predicted, before.rows[i].costs[part].predicted);
    }
  }
}

TEST(EvaluationOfFrames, has_the_selectors_that_all_of_them_allow) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 4, 60);
  const auto selectors = [&] {
    std::set<std::string> names;
    for (const EvaluationRow& row : sim::evaluate({frames}, small_options(), 1).rows) names.insert(row.selector);
    return names;
  };
  const std::set<std::string> usual = {"md",     "md_spread",    "md_ungated", "random_gated",
                                       "random", "bucket_gated", "aligned"};
  for (std::size_t i = 0; i < 3; ++i) frames[i].has_selection = true;
  EXPECT_EQ(selectors(), usual) << "the last frame has no selection";
  frames[3].has_selection = true;
  std::set<std::string> all = usual;
  all.insert("own");
  EXPECT_EQ(selectors(), all);
  for (Frame& frame : frames) {
    for (Match& match : frame.matches) match.is_selected = true;
  }
  EXPECT_EQ(selectors(), usual) << "the tracker used all matches";
}

// Of selectors whose selections are nested, one selection serves all budgets.
TEST(EvaluationOfFrames, has_rows_of_the_frames_with_more_inliers_than_the_budget_whatever_other_budgets_there_are) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 3, 100);
  const std::vector<Frame> few = recording(random, FrameKind::rig, 2, 35);
  frames.insert(frames.end(), few.begin(), few.end());
  const Evaluation evaluation = sim::evaluate({frames}, small_options({150, 40, 20, 40}), 1);
  EXPECT_EQ(evaluation.row("md", 20)->frames, 5U);
  EXPECT_EQ(evaluation.row("md", 40)->frames, 3U);
  EXPECT_EQ(evaluation.row("random", 150)->frames, 0U);
  EXPECT_TRUE(std::isnan(evaluation.row("random", 150)->costs[0].growth.value));
  EXPECT_EQ(evaluation.row("md", 21), nullptr);
  EXPECT_EQ(evaluation.rows.size(), 6 * 3 + 1U) << "one of each budget, and the aligned pose";
  const Evaluation alone = sim::evaluate({frames}, small_options({20}), 1);
  for (const EvaluationRow& row : alone.rows) {
    EXPECT_EQ(evaluation.row(row.selector, 20)->costs[0].growth.value, row.costs[0].growth.value) << row.selector;
  }
}

// The recorded tracker's own selection, against poses optimised here. Bounded errors, of which none is rejected.
TEST(EvaluationOfFrames, own_selections_deviate_as_poses_optimised_directly) {
  TracedRandom random;
  const auto add = [&](Frame& frame) {
    for (Match& match : frame.matches) shift(match, random.uniform(-1, 1), random.uniform(-1, 1));
  };
  std::vector<Frame> frames = simulated_recording(random, FrameKind::stereo, 9, 80, add, 1);
  Parts squares = Parts::Zero();
  std::size_t i = 0;
  for (Frame& frame : frames) {
    frame.has_selection = true;
    Subset selected;
    for (const std::uint32_t m : all_matches(frame)) {
      if (m % 3 != 0 && selected.size() <= 30 + i) selected.push_back(m);
    }
    for (const std::uint32_t m : selected) frame.matches[m].is_selected = true;
    PoseOptions options = precise(sim::PoseMethod::levenberg_marquardt);
    const double noise = evaluate_frame(frame, i, small_options()).median_chi2;
    options.huber_monocular = std::sqrt(2.25 * noise);
    options.huber_stereo = std::sqrt(3.47 * noise);
    const auto pose = [&](const Subset& of) {
      return optimize_pose(frame.camera, frame.matches, of, pose_of(frame), options);
    };
    const PoseEstimate all = pose(all_matches(frame));
    squares += squares_of(difference(pose(selected).T_cw, all.T_cw)) / traces_of(all.covariance());
    ++i;
  }
  const Evaluation evaluation = sim::evaluate({frames}, small_options(), 1);
  ASSERT_EQ(evaluation.inliers, 80);
  const EvaluationRow* const own = evaluation.row("own", 0);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(own->budget, 35U) << "the mean number of selected matches";
  for (const int part : {0, 1}) {
    const double growth = std::sqrt(1 + squares(part) / 9 / evaluation.chi2) - 1;
    EXPECT_NEAR(own->costs[static_cast<std::size_t>(part)].growth.value, growth, 1e-4);
  }
}

TEST(EvaluationOfFrames, errors_of_steps_against_true_poses_are_those_of_motions) {
  TracedRandom random;
  // Two recordings: no step leads from one to the other, nor over a frame without a pose or without the truth.
  std::vector<Frame> first = recording(random, FrameKind::stereo, 6, 80);
  std::vector<Frame> second = recording(random, FrameKind::stereo, 7, 80);
  second[2].matches.resize(4);
  second[5].T_cw_true.reset();
  EvaluationOptions options = small_options({40});
  options.contestants = {{"md", Choice::md}};
  std::vector<FrameEvaluation> evaluated;
  std::vector<std::optional<Pose>> true_poses;
  for (const auto* const frames : {&first, &second}) {
    for (const Frame& frame : *frames) {
      evaluated.push_back(evaluate_frame(frame, evaluated.size(), options));
      true_poses.push_back(frame.T_cw_true ? std::optional<Pose>(sim::pose_of(*frame.T_cw_true)) : std::nullopt);
    }
  }
  const Evaluation evaluation = summarize(evaluated, {6, 7}, true_poses, options);
  Parts own_squares = Parts::Zero(), all_squares = Parts::Zero();
  for (const std::size_t f : {1U, 2U, 3U, 4U, 5U, 7U, 10U}) {  // 8, 9: no pose; 11, 12: no truth
    const auto error = [&](const Pose& before, const Pose& after) {
      return squares_of(difference(after * before.inverse(), *true_poses[f] * true_poses[f - 1]->inverse()));
    };
    const auto own = [&](std::size_t of) {
      return sim::exp_se3(evaluated[of].deviations[0][0].at(0).xi) * evaluated[of].all;
    };
    own_squares += error(own(f - 1), own(f));
    all_squares += error(evaluated[f - 1].all, evaluated[f].all);
  }
  const EvaluationRow& row = *evaluation.row("md", 40);
  EXPECT_EQ(row.steps, 7U);
  for (const int part : {0, 1}) {
    const sim::Statistic& growth = row.costs[static_cast<std::size_t>(part)].true_growth;
    EXPECT_NEAR(growth.value, std::sqrt(own_squares(part) / all_squares(part)) - 1, 1e-9);
    EXPECT_TRUE(growth.interval.low <= growth.value && growth.value <= growth.interval.high);
  }
}

// A column without values may have zeros, and a camera alone has no right image.
TEST(EvaluationOfFrames, right_columns_without_a_baseline_do_not_count) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::monocular, 4, 60);
  const std::string expected = to_json(sim::evaluate({frames}, small_options(), 1)).dump();
  for (Frame& frame : frames) {
    for (Match& match : frame.matches) match.u_right = random.uniform(0, 700);
  }
  EXPECT_EQ(to_json(sim::evaluate({frames}, small_options(), 1)).dump(), expected);
}

TEST(EvaluationOfFrames, the_unit_of_length_changes_nothing_but_lengths) {
  TracedRandom random;
  for (const FrameKind kind : frame_kinds) {
    const std::vector<Frame> frames = recording(random, kind, 12, 80);
    for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
      EvaluationOptions options = small_options();
      options.weighting = weighting;
      auto expected = to_json(sim::evaluate({frames}, options, 1));
      for (const int exponent : {-20, -7, 7, 20}) {
        SCOPED_TRACE(std::string(to_string(kind)) + ", " + to_string(weighting) + ", 2^" + std::to_string(exponent));
        const double per_metre = std::exp2(exponent);
        EvaluationOptions in_that_unit = options;
        in_that_unit.map_sigma *= per_metre;
        std::vector<Frame> scaled;
        for (const Frame& frame : frames) scaled.push_back(in_unit(frame, per_metre));
        auto json = to_json(sim::evaluate({scaled}, in_that_unit, 1));
        EXPECT_EQ(json.at("translation_sigma_mm"), per_metre * expected.at("translation_sigma_mm").get<double>());
        json["translation_sigma_mm"] = expected["translation_sigma_mm"];
        EXPECT_EQ(json.dump(), expected.dump());
      }
    }
  }
}

TEST(Resampling, every_resample_has_as_many_frames_of_each_recording_as_it_has) {
  const std::vector<std::size_t> lengths = {1, 4, 0, 37, 300};
  const auto resamples = sim::resample_frames(lengths, 200, 3);
  ASSERT_EQ(resamples.size(), 200U);
  for (const FrameCounts& counts : resamples) {
    ASSERT_EQ(counts.size(), 342U);
    auto first = counts.begin();
    for (const std::size_t length : lengths) {
      const auto end = first + static_cast<std::ptrdiff_t>(length);
      EXPECT_EQ(std::accumulate(first, end, 0U), length);
      first = end;
    }
  }
  EXPECT_EQ(sim::resample_frames(lengths, 200, 3), resamples);
  EXPECT_NE(sim::resample_frames(lengths, 200, 4), resamples);
  EXPECT_NE(resamples[0], resamples[1]);
}

// A resample is a sum of blocks of consecutive frames, in a circle: its counts rise and fall at their ends alone.
TEST(Resampling, blocks_are_of_neighbours_and_draw_all_frames_equally_often) {
  constexpr std::size_t n = 2000;
  for (const auto& [length, block] :
       {std::pair(5U, 1U), std::pair(23U, 4U), std::pair(50U, 10U), std::pair(400U, 10U)}) {
    FrameCounts sum(length, 0);
    for (const FrameCounts& counts : sim::resample_frames({length}, n, 7)) {
      std::size_t rises = 0;
      for (std::size_t f = 0; f < length; ++f) {
        const std::uint32_t before = counts[(f + length - 1) % length];
        if (counts[f] > before) rises += counts[f] - before;
        sum[f] += counts[f];
      }
      EXPECT_LE(rises, (length + block - 1) / block);
    }
    // Of a resample the count of a frame has a variance of at most 1.
    for (const std::uint32_t count : sum) EXPECT_NEAR(count, n, 5 * std::sqrt(n)) << length;
  }
}

TEST(Resampling, intervals_lie_between_linear_quantiles_if_these_are_known) {
  for (const double q : {0.0, 0.25, 0.5, 0.75, 1.0}) EXPECT_DOUBLE_EQ(sim::quantile_of({4, 1, 3, 2}, q), 1 + 3 * q);
  EXPECT_EQ(sim::quantile_of({7}, 0.3), 7);
  std::vector<double> values(1001);
  std::iota(values.rbegin(), values.rend(), 0.0);
  EXPECT_NEAR(sim::percentile_interval(values).low, 25, 1e-9);
  EXPECT_NEAR(sim::percentile_interval(values).high, 975, 1e-9);
  EXPECT_TRUE(std::isnan(sim::percentile_interval({}).low));
  EXPECT_TRUE(std::isnan(sim::percentile_interval({1, nan, 2}).high));
  std::vector<double> some_infinite(1000, 1.0);
  std::fill_n(some_infinite.begin(), 100, infinity);
  EXPECT_EQ(sim::percentile_interval(some_infinite).low, 1);
  EXPECT_EQ(sim::percentile_interval(some_infinite).high, infinity);
}

}  // namespace
}  // namespace maxlogdet::test
