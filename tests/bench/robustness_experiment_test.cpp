// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/robustness_experiment.hpp"

#include "bench/does_the_paper_hold/robustness_report.hpp"
#include "bench/world/match_noise.hpp"
#include "bench/world/outlier_rejection.hpp"
#include "bench/world/projection.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace maxlogdet::test {
namespace {

using sim::Disturbance;
using sim::DisturbedFrame;
using sim::RobustnessOptions;
using sim::RobustnessOutcome;
using sim::RobustnessRuns;
using sim::SelectorKind;

RobustnessOptions small_options() {
  RobustnessOptions options;
  options.matches = 120;
  options.budgets = {20, 40};
  return options;
}

// Negligible noise, and no disturbance.
RobustnessOptions perfect_options() {
  RobustnessOptions options = small_options();
  options.pixel_sigma = options.map_sigma = 1e-6;
  options.batch_translation = options.batch_rotation_deg = options.patch_sigma = options.focal_error_percent = 0;
  return options;
}

RobustnessRuns run_all(const RobustnessOptions& options, std::size_t runs) {
  RobustnessRuns outcomes;
  for (std::uint64_t run = 0; run < runs; ++run) outcomes.push_back(run_robustness(options, run));
  return outcomes;
}

std::vector<double> numbers_of(const std::vector<RobustnessOutcome>& outcomes) {
  std::vector<double> numbers;
  for (const RobustnessOutcome& o : outcomes) numbers.insert(numbers.end(), {o.translation_m, o.rotation_deg});
  return numbers;
}

// Residuals at the truth, px; rows that a match lacks are zero.
std::vector<Eigen::Vector3d> residuals_of(const DisturbedFrame& disturbed) {
  std::vector<Eigen::Vector3d> residuals;
  for (const sim::Match& match : disturbed.frame.matches) {
    sim::LinearizedMatch at;
    EXPECT_TRUE(linearize(disturbed.frame.camera, disturbed.true_T_cw, match, true, at));
    residuals.push_back(at.residual);
  }
  return residuals;
}

// The residual at the truth, whitened with the assumed noise.
Eigen::Vector3d whitened_residual(const DisturbedFrame& disturbed, std::size_t i) {
  Eigen::Vector3d e = residuals_of(disturbed)[i];
  const sim::Frame& frame = disturbed.frame;
  whitening_of(frame.camera, disturbed.true_T_cw, frame.matches[i], true,
               Eigen::Map<const Eigen::Matrix3d>(frame.map_covariances[i].data()))
      .apply(e[0], e[1], e[2]);
  return e;
}

TEST(Robustness, a_run_is_deterministic_and_depends_on_number_and_seed) {
  RobustnessOptions options = small_options();
  const auto first = numbers_of(run_robustness(options, 3));
  EXPECT_EQ(first.size(), 2 * robustness_cases(options).size());
  EXPECT_EQ(numbers_of(run_robustness(options, 3)), first);
  EXPECT_NE(numbers_of(run_robustness(options, 4)), first);
  options.seed = 1;
  EXPECT_NE(numbers_of(run_robustness(options, 3)), first);
}

TEST(Robustness, a_budget_or_disturbance_does_not_change_another_ones_errors) {
  RobustnessOptions options = small_options(), fewer = options;
  fewer.budgets = {40};
  fewer.disturbances = {Disturbance::patches};
  const auto all = run_robustness(options, 2), some = run_robustness(fewer, 2);
  const auto cases = robustness_cases(options), some_cases = robustness_cases(fewer);
  for (std::size_t s = 0; s < some_cases.size(); ++s) {
    const auto same = std::find_if(cases.begin(), cases.end(), [&](const sim::RobustnessCase& one) {
      return one.disturbance == some_cases[s].disturbance && one.selector == some_cases[s].selector &&
             one.budget == some_cases[s].budget;
    });
    ASSERT_NE(same, cases.end());
    EXPECT_EQ(all[static_cast<std::size_t>(same - cases.begin())].translation_m, some[s].translation_m)
        << to_string(some_cases[s].selector);
  }
}

TEST(Robustness, the_truth_is_found_without_noise) {
  for (const sim::Scene scene : sim::robustness_scenes) {
    RobustnessOptions options = perfect_options();
    options.scene = scene;
    options.disturbances = {Disturbance::none,       Disturbance::batches,      Disturbance::patches,
                            Disturbance::sigma_half, Disturbance::sigma_uneven, Disturbance::focal};
    for (const RobustnessOutcome& outcome : run_robustness(options, 1)) {
      EXPECT_LT(outcome.translation_m, 1e-5) << to_string(scene);
      EXPECT_LT(outcome.rotation_deg, 1e-4) << to_string(scene);
    }
  }
}

TEST(Robustness, errors_of_points_and_pixels_are_as_selectors_assume) {
  RobustnessOptions options;
  double sum = 0, rows = 0;
  for (std::uint64_t run = 0; run < 6; ++run) {
    const DisturbedFrame disturbed = disturbed_frame(options, Disturbance::none, run);
    for (std::size_t i = 0; i < options.matches; ++i) {
      sum += whitened_residual(disturbed, i).squaredNorm();
      rows += disturbed.frame.matches[i].is_stereo() ? 3 : 2;
    }
  }
  EXPECT_NEAR(sum / rows, 1, 0.06) << "except for linearisation";
}

TEST(Robustness, sigma_is_assumed_to_be_half_or_twice_as_large) {
  const RobustnessOptions options = small_options();
  const auto matches_of = [&](Disturbance disturbance) {
    return disturbed_frame(options, disturbance, 1).frame.matches;
  };
  const auto none = matches_of(Disturbance::none), half = matches_of(Disturbance::sigma_half),
             twice = matches_of(Disturbance::sigma_double), uneven = matches_of(Disturbance::sigma_uneven);
  const auto residuals = residuals_of(disturbed_frame(options, Disturbance::none, 1));
  const auto uneven_residuals = residuals_of(disturbed_frame(options, Disturbance::sigma_uneven, 1));
  std::size_t louder = 0;
  for (std::size_t i = 0; i < options.matches; ++i) {
    EXPECT_EQ(half[i].u, none[i].u);
    EXPECT_NEAR(half[i].inv_sigma2 / none[i].inv_sigma2, 4, 1e-9);
    EXPECT_NEAR(twice[i].inv_sigma2 / none[i].inv_sigma2, 0.25, 1e-9);
    EXPECT_EQ(uneven[i].inv_sigma2, none[i].inv_sigma2) << "unknown to the model";
    if (uneven[i].u == none[i].u) {
      EXPECT_GT(none[i].u, 752 / 2.0 - 20);
    } else {
      EXPECT_LT(none[i].u, 752 / 2.0 + 20);
      ++louder;
    }
  }
  EXPECT_NEAR(static_cast<double>(louder), 60, 25);
}

TEST(Robustness, batches_move_the_points_of_a_keyframe_together_by_the_configured_error) {
  RobustnessOptions options = perfect_options();
  options.matches = 400;
  options.keyframes = 5;
  options.batch_translation = 0.02;
  std::map<std::int64_t, std::vector<Eigen::Vector3d>> shifts;
  const auto before = disturbed_frame(options, Disturbance::none, 1).frame.matches;
  const auto after = disturbed_frame(options, Disturbance::batches, 1).frame.matches;
  for (std::size_t i = 0; i < before.size(); ++i) {
    ASSERT_EQ(after[i].u, before[i].u);
    shifts[after[i].keyframe].push_back(Eigen::Map<const Eigen::Vector3d>(after[i].point) -
                                        Eigen::Map<const Eigen::Vector3d>(before[i].point));
  }
  ASSERT_EQ(shifts.size(), 5U);
  double sum = 0;
  for (const auto& [keyframe, of_batch] : shifts) {
    EXPECT_GE(keyframe, 0);
    EXPECT_LT(keyframe, 5);
    EXPECT_GT(of_batch.size(), 40U);
    for (const Eigen::Vector3d& shift : of_batch) EXPECT_LT((shift - of_batch.front()).norm(), 1e-6);
    sum += of_batch.front().squaredNorm();
  }
  EXPECT_GT(std::sqrt(sum / 15), 0.01);
  EXPECT_LT(std::sqrt(sum / 15), 0.03);
}

TEST(Robustness, patches_share_an_error_in_u_and_v_and_u_right_has_that_of_u) {
  RobustnessOptions options = perfect_options();
  options.matches = 400;
  options.patch_sigma = 0.5;
  const sim::Frame none = disturbed_frame(options, Disturbance::none, 1).frame;
  const sim::Frame frame = disturbed_frame(options, Disturbance::patches, 1).frame;
  std::map<std::uint32_t, Eigen::Vector2d> errors;
  std::size_t shared = 0;
  for (std::size_t i = 0; i < options.matches; ++i) {
    const sim::Match& match = frame.matches[i];
    const Eigen::Vector2d error(match.u - none.matches[i].u, match.v - none.matches[i].v);
    if (match.is_stereo() && match.u_right > 0) {
      EXPECT_NEAR(match.u_right - none.matches[i].u_right, error[0], 1e-9);
    }
    const auto [found, is_new] = errors.emplace(sim::ImageGrid{10, 8}.cell_of(none, none.matches[i]), error);
    EXPECT_LT((found->second - error).norm(), 1e-9);
    if (!is_new) ++shared;
  }
  EXPECT_GT(shared, 300U);
  double sum = 0;
  for (const auto& [cell, error] : errors) sum += error.squaredNorm() / (2 * static_cast<double>(errors.size()));
  EXPECT_NEAR(std::sqrt(sum), 0.5, 0.15);
}

TEST(Robustness, wrong_matches_have_the_configured_rate_and_are_uniform_within_the_gate) {
  for (const double gate : {1.0, 4.0}) {
    RobustnessOptions options;
    options.gate = gate;
    const std::map<Disturbance, std::size_t> expected = {
        {Disturbance::none, 0}, {Disturbance::wrong_5, 25}, {Disturbance::wrong_10, 50}, {Disturbance::wrong_20, 100}};
    const sim::RejectionOptions limits;
    for (const auto& [disturbance, count] : expected) {
      const DisturbedFrame disturbed = disturbed_frame(options, disturbance, 2);
      const DisturbedFrame none = disturbed_frame(options, Disturbance::none, 2);
      EXPECT_EQ(static_cast<std::size_t>(std::count(disturbed.is_wrong.begin(), disturbed.is_wrong.end(), 1)), count);
      std::size_t inner = 0, outer = 0;
      for (std::size_t i = 0; i < options.matches; ++i) {
        const bool is_changed = disturbed.frame.matches[i].u != none.frame.matches[i].u;
        EXPECT_EQ(is_changed, disturbed.is_wrong[i] != 0);
        if (!is_changed) continue;
        const bool is_stereo = disturbed.frame.matches[i].is_stereo();
        const double limit = gate * (is_stereo ? limits.chi2_stereo : limits.chi2_monocular);
        const double chi2 = whitened_residual(disturbed, i).squaredNorm();
        EXPECT_LE(chi2, limit * (1 + 1e-9));
        // Half of a ball's volume is within 0.794 of its radius, of a disc's area within 0.707.
        ++(std::sqrt(chi2 / limit) < (is_stereo ? 0.7937 : 0.7071) ? inner : outer);
      }
      EXPECT_NEAR(static_cast<double>(inner), static_cast<double>(outer),
                  5 * std::sqrt(static_cast<double>(count)) + 1e-9);
    }
  }
}

TEST(Robustness, a_wrong_focal_length_makes_all_errors_grow) {
  RobustnessOptions options = small_options();
  options.disturbances = {Disturbance::none, Disturbance::focal};
  options.focal_error_percent = 5;
  const auto rows = summarize(options, run_all(options, 10));
  const std::size_t half = rows.size() / 2;
  for (std::size_t c = 0; c < half; ++c) {
    EXPECT_GT(rows[half + c].translation_m.value, 2 * rows[c].translation_m.value);
  }
}

// Claims of docs/experiments.md, with few runs.
TEST(Robustness, md_is_better_than_random_and_the_shared_model_better_than_md) {
  RobustnessOptions options;
  options.budgets = {60};
  options.disturbances = {Disturbance::none, Disturbance::batches, Disturbance::patches};
  const auto runs = std::max<std::uint64_t>(trials(100), 30);  // with fewer, chance decides
  const auto rows = summarize(options, run_all(options, runs));
  const auto row_of = [&](Disturbance disturbance, SelectorKind kind) {
    return *std::find_if(rows.begin(), rows.end(), [&](const sim::RobustnessRow& row) {
      return row.which.disturbance == disturbance && row.which.selector == kind;
    });
  };
  EXPECT_LT(row_of(Disturbance::none, SelectorKind::random).md_translation_percent.value, -30);
  EXPECT_LT(row_of(Disturbance::none, SelectorKind::random).md_rotation_percent.value, -20);
  EXPECT_GT(row_of(Disturbance::none, SelectorKind::all).md_rotation_percent.value, 30);
  EXPECT_LT(row_of(Disturbance::none, SelectorKind::shared_keyframes).md_rotation_percent.value, 0);
  EXPECT_GT(row_of(Disturbance::batches, SelectorKind::shared_keyframes).md_rotation_percent.value, 10);
  EXPECT_EQ(row_of(Disturbance::batches, SelectorKind::md).md_rotation_percent.value, 0);
}

// Why an error of a keyframe affects md: one keyframe mapped almost half of its selection.
TEST(Robustness, md_selects_mostly_points_of_one_keyframe_and_shared_keyframes_fewer) {
  const RobustnessOptions options;
  std::map<SelectorKind, double> of_last;
  for (std::uint64_t run = 0; run < 50; ++run) {
    const sim::Frame frame = disturbed_frame(options, Disturbance::none, run).frame;
    std::vector<std::uint32_t> candidates(options.matches);
    std::iota(candidates.begin(), candidates.end(), 0U);
    for (const SelectorKind kind : {SelectorKind::md, SelectorKind::shared_keyframes, SelectorKind::md_keyframes}) {
      sim::SelectorSettings settings;
      settings.kind = kind;
      settings.budget = 60;
      settings.blocks.weighting = Weighting::measurement_and_map;
      settings.blocks.depth_cue = DepthCue::stereo;
      for (const std::uint32_t i : sim::FeatureSelector(settings).select(frame, candidates)) {
        of_last[kind] += frame.matches[i].keyframe == 7 ? 1 / (50 * 60.0) : 0;
      }
    }
  }
  EXPECT_NEAR(of_last[SelectorKind::md], 0.46, 0.04);
  EXPECT_NEAR(of_last[SelectorKind::shared_keyframes], 0.40, 0.04);
  EXPECT_NEAR(of_last[SelectorKind::md_keyframes], 0.25, 0.02);
}

TEST(Robustness, outcomes_come_back_from_json) {
  auto outcomes = run_robustness(small_options(), 0);
  outcomes[3].rotation_deg = std::numeric_limits<double>::quiet_NaN();
  const auto same = sim::robustness_outcomes_of(nlohmann::json::parse(to_json(outcomes).dump()));
  ASSERT_EQ(same.size(), outcomes.size());
  for (std::size_t i = 0; i < same.size(); ++i) {
    EXPECT_EQ(same[i].translation_m, outcomes[i].translation_m);
    EXPECT_EQ(std::isnan(same[i].rotation_deg), i == 3);
  }
}

// One budget, two disturbances: rotation errors of md are half of, as large as, and twice those of the others.
TEST(RobustnessReport, reports_differences_of_md_and_no_verdict_on_ties) {
  RobustnessOptions options = small_options();
  options.budgets = {20};
  options.disturbances = {Disturbance::none, Disturbance::focal};
  const auto cases = robustness_cases(options);
  RobustnessRuns runs(10);
  for (std::size_t run = 0; run < runs.size(); ++run) {
    for (const sim::RobustnessCase& which : cases) {
      RobustnessOutcome outcome = {1 + 0.1 * static_cast<double>(run), 1 + 0.1 * static_cast<double>(run)};
      if (which.selector == SelectorKind::random) outcome.rotation_deg *= 2;
      if (which.selector == SelectorKind::all) outcome.rotation_deg /= 2;
      if (which.selector == SelectorKind::bucket) outcome.translation_m += (run % 2 == 0 ? 0.5 : -0.5);
      runs[run].push_back(outcome);
    }
  }
  const sim::Table table = robustness_differences(options, runs, 20);
  ASSERT_EQ(table.rows.size(), 2U);
  const auto cell = [&](const char* column) {
    const auto found = std::find(table.header.begin(), table.header.end(), column);
    return table.rows[1].at(static_cast<std::size_t>(found - table.header.begin()));
  };
  EXPECT_EQ(cell("random"), "0.0 ± 0.0 ·, -50.0 ± 0.0 ▲");
  EXPECT_EQ(cell("all"), "0.0 ± 0.0 ·, 100.0 ± 0.0 ▼");
  EXPECT_EQ(cell("bucket").substr(cell("bucket").find(',') - 3, 3), " ·") << cell("bucket");
  EXPECT_EQ(cell("md against"), "focal");
  EXPECT_TRUE(summarize(options, {}).empty());
}

}  // namespace
}  // namespace maxlogdet::test
