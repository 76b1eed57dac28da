// SPDX-License-Identifier: MIT
// Which frames and selections an evaluation takes, and what it computes of them.
#include "bench/does_it_help/evaluation.hpp"

#include "bench/does_it_help/report.hpp"
#include "tests/bench/precise_pose.hpp"
#include "tests/bench/simulated_evaluation.hpp"
#include "tests/support/support.hpp"

#include <set>

namespace maxlogdet::test {
namespace {

std::vector<Frame> recording(Random& random, FrameKind kind, std::size_t frames, std::size_t n) {
  return simulated_recording(random, kind, frames, n, [&](Frame& frame) { add_errors(random, frame); });
}

EvaluationOptions small_options() {
  EvaluationOptions options;
  options.budgets = {20, 40};
  options.repeats = 2;
  return options;
}

std::set<std::string> selectors_of(const Evaluation& evaluation) {
  std::set<std::string> names;
  for (const EvaluationRow& row : evaluation.rows) names.insert(row.selector);
  return names;
}

TEST(EvaluationOfFrames, leaves_out_and_counts_those_without_a_pose) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 12, 60);
  const Evaluation before = sim::evaluate({{frames.begin(), frames.begin() + 9}}, small_options(), 1);
  frames[9].matches.resize(9);                                       // too few
  for (Match& match : frames[10].matches) match.u = 5000 - match.u;  // they agree with no pose
  const Pose turned = Pose(Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY()));
  frames[11].T_cw_prior = sim::to_rows(turned * sim::pose_of(frames[11].T_cw_prior));  // all are behind the camera
  const Evaluation after = sim::evaluate({frames}, small_options(), 1);
  EXPECT_EQ(after.frames, 12U);
  EXPECT_EQ(after.unusable, 3U);
  EXPECT_EQ(after.matches, before.matches);
  EXPECT_EQ(after.inliers, before.inliers);
  ASSERT_EQ(after.rows.size(), before.rows.size());
  for (std::size_t i = 0; i < after.rows.size(); ++i) {
    EXPECT_EQ(after.rows[i].frames, 9U);
    for (const std::size_t part : {0U, 1U}) {
      EXPECT_EQ(after.rows[i].costs[part].growth.value, before.rows[i].costs[part].growth.value);
      EXPECT_EQ(after.rows[i].costs[part].predicted, before.rows[i].costs[part].predicted);
    }
  }
  EXPECT_EQ(after.chi2, before.chi2);
  EXPECT_EQ(after.cell_correlation.value, before.cell_correlation.value);
}

TEST(EvaluationOfFrames, has_the_selectors_that_all_of_them_allow) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 4, 60);
  const std::set<std::string> usual = {"md",     "md_spread",    "md_ungated", "random_gated",
                                       "random", "bucket_gated", "bucket",     "aligned"};
  EXPECT_EQ(selectors_of(sim::evaluate({frames}, small_options(), 1)), usual);
  for (std::size_t i = 0; i < 3; ++i) frames[i].has_quality = frames[i].has_selection = true;
  EXPECT_EQ(selectors_of(sim::evaluate({frames}, small_options(), 1)), usual) << "the last frame does not";
  frames[3].has_quality = frames[3].has_selection = true;
  std::set<std::string> all = usual;
  all.insert({"quality_gated", "quality", "own"});
  EXPECT_EQ(selectors_of(sim::evaluate({frames}, small_options(), 1)), all);
  for (Frame& frame : frames) {
    for (Match& match : frame.matches) match.is_selected = true;
  }
  all.erase("own");
  EXPECT_EQ(selectors_of(sim::evaluate({frames}, small_options(), 1)), all) << "the tracker used all matches";
  const std::vector<Frame> of_depth = recording(random, FrameKind::depth, 4, 60);
  EXPECT_EQ(selectors_of(sim::evaluate({of_depth}, small_options(), 1)), usual);
}

TEST(EvaluationOfFrames, has_rows_of_the_frames_with_more_inliers_than_the_budget) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 3, 100);
  const std::vector<Frame> few = recording(random, FrameKind::stereo, 2, 35);
  frames.insert(frames.end(), few.begin(), few.end());
  EvaluationOptions options = small_options();
  options.budgets = {20, 40, 150};
  const Evaluation evaluation = sim::evaluate({frames}, options, 1);
  EXPECT_EQ(evaluation.row("md", 20)->frames, 5U);
  EXPECT_EQ(evaluation.row("md", 40)->frames, 3U);
  EXPECT_EQ(evaluation.row("random", 150)->frames, 0U);
  EXPECT_TRUE(std::isnan(evaluation.row("random", 150)->costs[0].growth.value));
  EXPECT_EQ(evaluation.row("md", 21), nullptr);
}

// The recorded tracker's own selection, against poses optimised here.
TEST(EvaluationOfFrames, own_selections_deviate_as_poses_optimised_directly) {
  TracedRandom random;
  // Bounded errors, of which none is rejected.
  std::vector<Frame> frames = simulated_recording(
      random, FrameKind::stereo, 9, 80,
      [&](Frame& frame) {
        for (Match& match : frame.matches) shift(match, random.uniform(-1, 1), random.uniform(-1, 1));
      },
      1);
  sim::Parts squares = sim::Parts::Zero();
  std::size_t i = 0;
  for (Frame& frame : frames) {
    frame.has_selection = true;
    Subset selected;
    for (const std::uint32_t m : all_matches(frame)) {
      if (m % 3 != 0 && selected.size() <= 30 + i) selected.push_back(m);
    }
    for (const std::uint32_t m : selected) frame.matches[m].is_selected = true;
    PoseOptions options = precise(PoseMethod::levenberg_marquardt);
    const double noise = evaluate_frame(frame, i, small_options()).median_chi2;
    options.huber_monocular = std::sqrt(2.25 * noise);
    options.huber_stereo = std::sqrt(3.47 * noise);
    const Pose start = sim::pose_of(frame.T_cw_prior);
    const auto pose = [&](const Subset& of) { return optimize_pose(frame.camera, frame.matches, of, start, options); };
    const PoseEstimate all = pose(all_matches(frame));
    const sim::Vector6 xi = difference(pose(selected).T_cw, all.T_cw);
    const sim::Matrix6 covariance = all.covariance();
    squares += sim::Parts(xi.head<3>().squaredNorm() / covariance.topLeftCorner<3, 3>().trace(),
                          xi.tail<3>().squaredNorm() / covariance.bottomRightCorner<3, 3>().trace());
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

// Of selectors whose selections are nested, one selection serves all budgets.
TEST(EvaluationOfFrames, nested_selections_begin_with_the_smaller_ones) {
  TracedRandom random;
  for (const FrameKind kind : {FrameKind::stereo, FrameKind::fisheye, FrameKind::rig}) {
    Frame frame = simulated_frame(random, kind, 90);
    for (Match& match : frame.matches) match.desc_dist = random.integer(0, 20);
    for (const SelectorKind selector :
         {SelectorKind::md, SelectorKind::bucket, SelectorKind::random, SelectorKind::quality}) {
      EXPECT_TRUE((sim::Contestant{"", selector}.is_nested()));
      sim::SelectorSettings settings;
      settings.kind = selector;
      settings.seed = 5;
      settings.blocks.depth_cue = frame.camera.depth_cue();
      settings.budget = 70;
      const Subset most = sim::FeatureSelector(settings).select(frame, all_matches(frame));
      for (settings.budget = 6; settings.budget < 70; settings.budget += 9) {
        const Subset fewer = sim::FeatureSelector(settings).select(frame, all_matches(frame));
        EXPECT_EQ(fewer, Subset(most.begin(), most.begin() + static_cast<std::ptrdiff_t>(settings.budget)))
            << to_string(selector);
      }
    }
  }
}

TEST(EvaluationOfFrames, budgets_are_sorted_and_given_once) {
  EvaluationOptions options;
  options.budgets = {100, 30, 100};
  EXPECT_EQ(budgets_of({"", SelectorKind::md}, options), (std::vector<std::size_t>{30, 100}));
  EXPECT_EQ(budgets_of({"", SelectorKind::all}, options), (std::vector<std::size_t>{0}));
  EXPECT_EQ(budgets_of({"", SelectorKind::md, true, true}, options), (std::vector<std::size_t>{0})) << "own";
}

TEST(EvaluationOfFrames, errors_of_steps_against_true_poses_are_those_of_motions) {
  TracedRandom random;
  // Two recordings: no step leads from one to the other, nor over a frame without a pose or without the truth.
  std::vector<Frame> first = recording(random, FrameKind::stereo, 6, 80);
  std::vector<Frame> second = recording(random, FrameKind::stereo, 7, 80);
  second[2].matches.resize(4);
  second[5].T_cw_true.reset();
  EvaluationOptions options = short_options();
  options.budgets = {40};
  std::vector<FrameEvaluation> evaluated;
  std::vector<std::optional<Pose>> true_poses;
  for (const auto* const frames : {&first, &second}) {
    for (const Frame& frame : *frames) {
      evaluated.push_back(evaluate_frame(frame, evaluated.size(), options));
      true_poses.push_back(frame.T_cw_true ? std::optional<Pose>(sim::pose_of(*frame.T_cw_true)) : std::nullopt);
    }
  }
  const Evaluation evaluation = summarize(evaluated, {6, 7}, true_poses, options);
  sim::Parts own_squares = sim::Parts::Zero(), all_squares = sim::Parts::Zero();
  for (const std::size_t f : {1U, 2U, 3U, 4U, 5U, 7U, 10U}) {  // 8, 9: no pose; 11, 12: no truth
    const auto error = [&](const Pose& before, const Pose& after) {
      const Pose motion = after * before.inverse(), truth = *true_poses[f] * true_poses[f - 1]->inverse();
      return difference(motion, truth);
    };
    const auto own = [&](std::size_t of) {
      return sim::exp_se3(evaluated[of].deviations[0][0].at(0).xi) * evaluated[of].all;
    };
    const sim::Vector6 e = error(own(f - 1), own(f)), of_all = error(evaluated[f - 1].all, evaluated[f].all);
    own_squares += sim::Parts(e.head<3>().squaredNorm(), e.tail<3>().squaredNorm());
    all_squares += sim::Parts(of_all.head<3>().squaredNorm(), of_all.tail<3>().squaredNorm());
  }
  const EvaluationRow& row = *evaluation.row("md", 40);
  EXPECT_EQ(row.steps, 7U);
  for (const int part : {0, 1}) {
    const sim::Estimate& growth = row.costs[static_cast<std::size_t>(part)].true_growth;
    EXPECT_NEAR(growth.value, std::sqrt(own_squares(part) / all_squares(part)) - 1, 1e-9);
    EXPECT_TRUE(contains(growth.interval, growth.value));
  }
  for (std::optional<Pose>& pose : true_poses) pose.reset();
  EXPECT_EQ(summarize(evaluated, {6, 7}, true_poses, options).row("md", 40)->steps, 0U);
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

void round_to_float32(Frame& frame) {
  for (Match& match : frame.matches) {
    for (double* const number :
         {match.point, match.point + 1, match.point + 2, &match.u, &match.v, &match.u_right, &match.depth}) {
      *number = static_cast<float>(*number);
    }
  }
}

TEST(EvaluationOfFrames, without_noise_cannot_tell) {
  TracedRandom random;
  for (const FrameKind kind : frame_kinds) {
    for (const double noise : {0.0, 1e-9, 1e-6, 1e-4, nan}) {
      const bool is_float32 = std::isnan(noise);  // as a tracker in float32 records without noise
      if (is_float32 && (kind == FrameKind::fisheye || kind == FrameKind::rig)) continue;
      SCOPED_TRACE(std::string(to_string(kind)) + " " + std::to_string(noise));
      const auto frames = simulated_recording(random, kind, 12, 60, [&](Frame& frame) {
        if (noise > 0) add_errors(random, frame, noise);
        if (is_float32) return round_to_float32(frame);
        frame.matches[0].v += 100;  // a wrong one
      });
      const std::string text = to_text(sim::evaluate({frames}, small_options(), 1));
      EXPECT_EQ(text.rfind("These frames cannot tell: their residuals are rounding errors", 0), 0U) << text;
      EXPECT_EQ(text.find('|'), std::string::npos) << "tables of rounding errors";
    }
  }
}

TEST(EvaluationOfFrames, noise_far_below_the_modelled_one_is_noise_all_the_same) {
  TracedRandom random;
  const auto frames =
      simulated_recording(random, FrameKind::stereo, 12, 160, [&](Frame& frame) { add_errors(random, frame, 0.05); });
  EvaluationOptions options = small_options();
  options.budgets = {100};
  const std::string text = to_text(sim::evaluate({frames}, options, 1));
  EXPECT_EQ(text.rfind("Max-logDet pays: with 100 of some ", 0), 0U) << text;
}

// frame_noise_test.cpp has the noise of a frame.
TEST(EvaluationOfFrames, chi2_of_a_decile_is_the_sum_of_its_frames) {
  TracedRandom random;
  std::vector<FrameEvaluation> evaluated;
  for (const Frame& frame : recording(random, FrameKind::stereo, 4, 60)) {
    evaluated.push_back(evaluate_frame(frame, evaluated.size(), short_options()));
  }
  double chi2 = 0, freedom = 0;
  for (std::size_t f = 0; f < evaluated.size(); ++f) {
    for (std::size_t d = 0; d < sim::leverage_classes; ++d) {
      evaluated[f].noise.freedom[d] = static_cast<double>(f + 1);
      evaluated[f].noise.chi2[d] = static_cast<double>((f + 1) * (d + 1));
      freedom += evaluated[f].noise.freedom[d];
      chi2 += evaluated[f].noise.chi2[d];
    }
  }
  const Evaluation evaluation = summarize(evaluated, {4}, std::vector<std::optional<Pose>>(4), short_options());
  constexpr double within_limits = 0.975;  // of inliers' chi2
  for (std::size_t d = 0; d < sim::leverage_classes; ++d) {
    EXPECT_NEAR(evaluation.chi2_by_leverage[d].value, static_cast<double>(d + 1) / within_limits, 1e-12);
  }
  EXPECT_NEAR(evaluation.chi2, chi2 / freedom / within_limits, 1e-12);
}

}  // namespace
}  // namespace maxlogdet::test
