// SPDX-License-Identifier: MIT
// Which frames and selections an evaluation takes, and what it computes of them.
#include "bench/does_it_help/evaluation.hpp"

#include "bench/does_it_help/report.hpp"
#include "tests/bench/precise_pose.hpp"
#include "tests/bench/simulated_evaluation.hpp"
#include "tests/support/traced_random.hpp"

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
    EXPECT_EQ(after.rows[i].translation.median, before.rows[i].translation.median);
    EXPECT_EQ(after.rows[i].rotation.predicted, before.rows[i].rotation.predicted);
  }
  EXPECT_EQ(after.chi2_by_leverage, before.chi2_by_leverage);
  EXPECT_EQ(after.cell_correlation.value, before.cell_correlation.value);
}

TEST(EvaluationOfFrames, has_the_selectors_that_all_of_them_allow) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 4, 60);
  const std::set<std::string> usual = {"md", "md_spread", "md_cells", "bucket", "random"};
  EXPECT_EQ(selectors_of(sim::evaluate({frames}, small_options(), 1)), usual);
  for (std::size_t i = 0; i < 3; ++i) frames[i].has_quality = frames[i].has_selection = true;
  EXPECT_EQ(selectors_of(sim::evaluate({frames}, small_options(), 1)), usual) << "the last frame does not";
  frames[3].has_quality = frames[3].has_selection = true;
  std::set<std::string> all = usual;
  all.insert({"quality", "own"});
  EXPECT_EQ(selectors_of(sim::evaluate({frames}, small_options(), 1)), all);
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
  EXPECT_TRUE(std::isnan(evaluation.row("random", 150)->translation.median));
  EXPECT_EQ(evaluation.row("md", 21), nullptr);
}

// The recorded tracker's own selection, against poses optimised here.
TEST(EvaluationOfFrames, own_selections_deviate_as_poses_optimised_directly) {
  TracedRandom random;
  std::vector<Frame> frames = recording(random, FrameKind::stereo, 9, 80);
  std::vector<double> translations, rotations;
  std::size_t i = 0;
  for (Frame& frame : frames) {
    frame.has_selection = true;
    Subset selected;
    for (const std::uint32_t m : all_matches(frame)) {
      if (m % 3 != 0 && selected.size() <= 30 + i) selected.push_back(m);
    }
    for (const std::uint32_t m : selected) frame.matches[m].is_selected = true;
    PoseOptions options = precise(PoseMethod::levenberg_marquardt);
    options.huber_monocular = std::sqrt(5.991);
    options.huber_stereo = std::sqrt(7.815);
    const Pose start = sim::pose_of(frame.T_cw_prior);
    const auto pose = [&](const Subset& of) { return optimize_pose(frame.camera, frame.matches, of, start, options); };
    const sim::Vector6 xi = difference(pose(selected).T_cw, pose(all_matches(frame)).T_cw);
    translations.push_back(xi.head<3>().norm());
    rotations.push_back(xi.tail<3>().norm());
    ++i;
  }
  const Evaluation evaluation = sim::evaluate({frames}, small_options(), 1);
  ASSERT_EQ(evaluation.inliers, 80) << "none was rejected: choose another seed";
  const EvaluationRow* const own = evaluation.row("own", 35);
  ASSERT_NE(own, nullptr) << "the median number of selected matches";
  std::sort(translations.begin(), translations.end());
  std::sort(rotations.begin(), rotations.end());
  const double terminated = PoseOptions().step_tolerance;  // what evaluate's poses are left short of
  EXPECT_NEAR(own->translation.median, translations[4], terminated);
  EXPECT_NEAR(own->rotation.median, rotations[4], terminated);
  EXPECT_NEAR(own->translation.p90, translations[8], terminated);
  EXPECT_TRUE(own->worth_random);
}

double median_of(std::vector<double> values) {  // of an odd number
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
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
  std::vector<double> own_m, own_rad, all_m, all_rad;
  for (const std::size_t f : {1U, 2U, 3U, 4U, 5U, 7U, 10U}) {  // 8, 9: no pose; 11, 12: no truth
    const auto error = [&](const Pose& before, const Pose& after) {
      const Pose motion = after * before.inverse(), truth = *true_poses[f] * true_poses[f - 1]->inverse();
      return difference(motion, truth);
    };
    const auto own = [&](std::size_t of) {
      return sim::exp_se3(evaluated[of].deviations[0][0].at(0).xi) * evaluated[of].all;
    };
    const sim::Vector6 e = error(own(f - 1), own(f)), of_all = error(evaluated[f - 1].all, evaluated[f].all);
    own_m.push_back(e.head<3>().norm());
    own_rad.push_back(e.tail<3>().norm());
    all_m.push_back(of_all.head<3>().norm());
    all_rad.push_back(of_all.tail<3>().norm());
  }
  const auto& truth = evaluation.row("md", 40)->truth;
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->steps, 7U);
  EXPECT_NEAR(truth->median_m, median_of(own_m), 1e-9 * truth->median_m);
  EXPECT_NEAR(truth->median_rad, median_of(own_rad), 1e-9 * truth->median_rad);
  EXPECT_NEAR(truth->translation_ratio, median_of(own_m) / median_of(all_m), 1e-9);
  EXPECT_NEAR(truth->rotation_ratio, median_of(own_rad) / median_of(all_rad), 1e-9);
  EXPECT_TRUE(contains(truth->of_translation_ratio, truth->translation_ratio));
  for (std::optional<Pose>& pose : true_poses) pose.reset();
  EXPECT_FALSE(summarize(evaluated, {6, 7}, true_poses, options).row("md", 40)->truth);
}

}  // namespace
}  // namespace maxlogdet::test
