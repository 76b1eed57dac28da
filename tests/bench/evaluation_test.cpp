// SPDX-License-Identifier: MIT
// What an evaluation computes of frames: noise against plain double loops, growth and steps against poses that are
// optimised here, resamples. verdict_test.cpp has what covariances predict, and what it concludes.
#include "cli/evaluation.hpp"

#include "bench/world/projection.hpp"
#include "cli/report.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/support.hpp"

#include <numeric>

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

// Whitened residuals and Jacobians at the pose of all, by plain variances.
std::pair<Eigen::VectorXd, Eigen::MatrixXd> whitened(const Frame& frame, const Pose& T_cw, const Match& match) {
  sim::LinearizedMatch at;
  EXPECT_TRUE(linearize(frame.camera, T_cw, match, true, at));
  Eigen::VectorXd deviations = Eigen::VectorXd::Constant(at.rows, 1 / std::sqrt(match.inv_sigma2));
  if (match.depth > 0) deviations(2) = frame.camera.depth_sigma;
  const Eigen::MatrixXd H = deviations.cwiseInverse().asDiagonal() * at.H_x().topRows(at.rows);
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
    std::vector<std::pair<double, std::size_t>> by_leverage;
    sim::PairSums pairs;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto [r, H] = whitened(frame, pose.T_cw, frame.matches[i]);
      by_leverage.emplace_back(product(H, product(C, H.transpose())).trace(), i);
      for (std::size_t j = 0; j <= i; ++j) {
        if (cell_of(frame.matches[i]) != cell_of(frame.matches[j])) continue;
        const auto [r_j, H_j] = whitened(frame, pose.T_cw, frame.matches[j]);
        const double product_of_both = r.head<2>().dot(r_j.head<2>());
        const double fitted = product(H.topRows(2), product(C, H_j.topRows(2).transpose())).trace();
        (i == j ? pairs.matches : pairs.pairs) += 1;
        (i == j ? pairs.squares : pairs.products) += product_of_both;
        (i == j ? pairs.fitted_self : pairs.fitted) += fitted;
      }
    }
    std::sort(by_leverage.begin(), by_leverage.end());
    std::array<double, sim::leverage_classes> chi2{}, freedom{};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto& [leverage, which] = by_leverage[i];
      const Eigen::VectorXd r = whitened(frame, pose.T_cw, frame.matches[which]).first;
      chi2[10 * i / all.size()] += r.squaredNorm();
      freedom[10 * i / all.size()] += static_cast<double>(r.size()) - leverage;
    }
    const sim::FrameNoise noise = noise_of(frame, pose, all, whitenings);
    EXPECT_GT(pairs.pairs, 0);
    EXPECT_EQ(std::pair(noise.pairs.pairs, noise.pairs.matches), std::pair(pairs.pairs, pairs.matches));
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

// Points next to the camera that are wrongly matched can lead a first round astray, where all others are far away.
TEST(EvaluationOfFrames, finds_the_pose_that_most_matches_fit_beside_wrong_points_next_to_the_camera) {
  TracedRandom random;
  std::size_t led_astray = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Frame frame = recording(random, FrameKind::monocular, 1, 200)[0];
    const Pose T_cw = sim::pose_of(*frame.T_cw_true);
    frame.T_cw_prior = sim::to_rows(random_pose(random, 0.05, 0.02) * T_cw);
    for (std::size_t i = 0; i < 200; ++i) {
      Match& match = frame.matches[i];
      const bool is_wrong = i % 4 == 0;
      Eigen::Vector3d p_c = 10 * (T_cw * Eigen::Vector3d(match.point));
      if (is_wrong) p_c = {random.uniform(-8, -5), random.uniform(-0.5, 0.5), random.uniform(0.5, 7)};
      const Eigen::Vector3d p_w = T_cw.inverse() * p_c;
      std::copy_n(p_w.data(), 3, match.point);
    }
    const FrameEvaluation found = evaluate_frame(frame, 0, small_options());
    ASSERT_TRUE(found.is_usable);
    EXPECT_LT(sim::camera_distance(found.all, T_cw), 1);
    const sim::Rejection by_rounds =
        reject_outliers(frame.camera, frame.matches, all_matches(frame), pose_of(frame), sim::RejectionOptions());
    led_astray += sim::camera_distance(by_rounds.estimate.T_cw, T_cw) > 1 ? 1 : 0;
  }
  EXPECT_GT(led_astray, 0U) << "otherwise this tests nothing";
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
  const auto numbers_of = [](const Evaluation& of) {
    std::vector<double> numbers = {of.matches, of.inliers, of.chi2, of.cell_correlation.value};
    for (const EvaluationRow& row : of.rows) {
      EXPECT_EQ(row.frames, 9U);
      for (const sim::Cost& cost : row.costs) numbers.insert(numbers.end(), {cost.growth.value, cost.predicted});
    }
    return numbers;
  };
  EXPECT_EQ(numbers_of(after), numbers_of(before));
}

TEST(EvaluationOfFrames, has_own_selections_that_all_of_them_have) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 4, 60);
  const auto has_own = [&] { return sim::evaluate({frames}, small_options(), 1).row("own", 0) != nullptr; };
  for (std::size_t i = 0; i < 3; ++i) frames[i].has_selection = true;
  EXPECT_FALSE(has_own()) << "the last frame has no selection";
  frames[3].has_selection = true;
  EXPECT_TRUE(has_own());
  for (Frame& frame : frames) {
    for (Match& match : frame.matches) match.is_selected = true;
  }
  EXPECT_FALSE(has_own()) << "the tracker used all matches";
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
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Frame& frame = frames[i];
    frame.has_selection = true;
    Subset selected;
    for (std::uint32_t m = 0; selected.size() <= 30 + i; ++m) {
      if (m % 3 == 0) continue;
      selected.push_back(m);
      frame.matches[m].is_selected = true;
    }
    PoseOptions options = precise(sim::PoseMethod::levenberg_marquardt);
    const double noise = evaluate_frame(frame, i, small_options()).median_chi2;
    options.huber_monocular = std::sqrt(2.25 * noise);
    options.huber_stereo = std::sqrt(3.47 * noise);
    const auto pose = [&](const Subset& of) {
      return optimize_pose(frame.camera, frame.matches, of, pose_of(frame), options);
    };
    const PoseEstimate all = pose(all_matches(frame));
    squares += squares_of(difference(pose(selected).T_cw, all.T_cw)) / traces_of(all.covariance());
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

// Nor do right columns of a camera alone, where a column without values may have zeros.
TEST(EvaluationOfFrames, the_unit_of_length_changes_nothing_but_lengths) {
  TracedRandom random;
  for (const FrameKind kind : frame_kinds) {
    std::vector<Frame> frames = recording(random, kind, 12, 80);
    for (const bool has_covariances : {false, true}) {
      for (std::size_t i = 0; has_covariances && i < frames.size(); ++i) set_some_covariances(random, frames[i]);
      const EvaluationOptions options = small_options();
      auto expected = to_json(sim::evaluate({frames}, options, 1));
      for (const int exponent : {-20, -7, 7, 20}) {
        SCOPED_TRACE(std::string(to_string(kind)) + (has_covariances ? ", covariances" : "") + ", 2^" +
                     std::to_string(exponent));
        const double per_metre = std::exp2(exponent);
        EvaluationOptions in_that_unit = options;
        in_that_unit.map_sigma *= per_metre;
        std::vector<Frame> scaled;
        for (const Frame& frame : frames) {
          scaled.push_back(in_unit(frame, per_metre));
          for (Match& match : scaled.back().matches) {
            if (kind == FrameKind::monocular) match.u_right = random.uniform(0, 700);
          }
        }
        auto json = to_json(sim::evaluate({scaled}, in_that_unit, 1));
        EXPECT_EQ(json.at("translation_sigma_mm"), per_metre * expected.at("translation_sigma_mm").get<double>());
        json["translation_sigma_mm"] = expected["translation_sigma_mm"];
        EXPECT_EQ(json.dump(), expected.dump());
      }
    }
  }
}

// A resample is a sum of blocks of consecutive frames, in a circle: its counts rise and fall at their ends alone.
TEST(Resampling, blocks_are_of_neighbours_in_each_recording_and_draw_all_its_frames_equally_often) {
  constexpr std::size_t n = 2000;
  const std::vector<std::size_t> lengths = {5, 23, 0, 1, 50, 400};
  const std::size_t block_lengths[] = {1, 4, 1, 1, 10, 10};
  const auto resamples = sim::resample_frames(lengths, n, 7);
  EXPECT_EQ(resamples.size(), n);
  EXPECT_EQ(sim::resample_frames(lengths, n, 7), resamples);
  EXPECT_NE(sim::resample_frames(lengths, n, 4), resamples);
  FrameCounts sum(479, 0);
  for (const FrameCounts& counts : resamples) {
    ASSERT_EQ(counts.size(), sum.size());
    std::size_t first = 0;
    for (std::size_t r = 0; r < lengths.size(); ++r) {
      const std::size_t length = lengths[r];
      std::size_t rises = 0, drawn = 0;
      for (std::size_t f = 0; f < length; ++f) {
        const std::uint32_t count = counts[first + f], before = counts[first + (f + length - 1) % length];
        if (count > before) rises += count - before;
        drawn += count;
        sum[first + f] += count;
      }
      EXPECT_EQ(drawn, length) << "as many as it has";
      EXPECT_LE(rises, (length + block_lengths[r] - 1) / block_lengths[r]);
      first += length;
    }
  }
  // Of a resample the count of a frame has a variance of at most 1.
  for (const std::uint32_t count : sum) EXPECT_NEAR(count, n, 5 * std::sqrt(n));
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
}

}  // namespace
}  // namespace maxlogdet::test
