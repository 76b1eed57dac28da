// SPDX-License-Identifier: MIT
#include "bench/does_it_track/report.hpp"
#include "bench/world/input_error.hpp"
#include "tests/odometry/rendered_world.hpp"

#include <cmath>
#include <set>
#include <sstream>

namespace maxlogdet::test {
namespace {

using sim::Pose;
using stereo_odometry::FrameResult;
using stereo_odometry::FrameStatus;
using stereo_odometry::Outcome;
using OdometryRun = stereo_odometry::Run;  // Test::Run hides the name in tests
using stereo_odometry::Summary;
using Row = std::vector<std::string>;

constexpr std::size_t frames = 15;

// At 10 Hz; without images, which reports do not use.
stereo_odometry::StereoDataset dataset_of(bool has_truth) {
  stereo_odometry::Recording recording;
  recording.camera = RenderedWorld::camera();
  recording.width = RenderedWorld::width;
  recording.height = RenderedWorld::height;
  for (std::size_t i = 0; i < frames; ++i) {
    stereo_odometry::Recording::Pair pair;
    pair.time = 0.1 * static_cast<double>(i);
    if (has_truth) pair.T_wc = RenderedWorld::T_wc(i);
    recording.pairs.push_back(pair);
  }
  return {"it's_made", recording};
}

// Five matches, one of the four inliers an outlier afterwards.
void fill_lists(FrameResult& result) {
  result.matches.resize(5);
  result.inliers = {0, 1, 2, 4};
  result.selected = {1, 2};
  result.is_outlier = {0, 1, 0, 1, 0};
}

// Along the truth, with an error of `drift` m in every frame's motion, alternately to the right and to the left of the
// camera, which no scale of the alignment removes.
OdometryRun run_along_truth(double drift = 0) {
  OdometryRun run;
  Pose T_wc = RenderedWorld::T_wc(0);
  for (std::size_t i = 0; i < frames; ++i) {
    if (i > 0) {
      T_wc = T_wc * RenderedWorld::T_wc(i - 1).inverse() * RenderedWorld::T_wc(i) *
             Eigen::Translation3d(i % 2 == 0 ? drift : -drift, 0, 0);
    }
    stereo_odometry::FrameRecord frame;
    frame.time = 0.1 * static_cast<double>(i);
    frame.ms_extraction = 10;
    frame.features = 500;
    frame.result.T_cw = T_wc.inverse();
    frame.result.status = i == 0 ? FrameStatus::initialized : FrameStatus::tracked;
    frame.result.searched = 300;
    fill_lists(frame.result);
    frame.result.ms = {1, 2, 3, 4, 5, 6, 7};
    frame.drop_lists();
    run.frames.push_back(frame);
  }
  return run;
}

Summary summary_of(const std::string& name, const std::vector<Outcome>& runs) {
  Summary summary;
  summary.contestant.name = summary.contestant.selector = name;
  summary.contestant.budget = 100;
  summary.runs = runs;
  return summary;
}

TEST(StereoOutcome, has_no_errors_where_the_estimate_is_the_truth) {
  const Outcome outcome = outcome_of(run_along_truth(), dataset_of(true));
  EXPECT_LT(outcome.per_frame.ate_m, 1e-12);
  EXPECT_LT(outcome.per_frame.rpe_m_per_s, 1e-12);
  EXPECT_LT(outcome.per_frame.roe_deg_per_s, 1e-5) << "an angle by its cosine may be that far off";
  EXPECT_EQ(outcome.per_frame.windows, frames - 1);
  EXPECT_EQ(outcome.per_second.windows, frames - 10);
  EXPECT_EQ(outcome.tracked_percent, 100);
}

TEST(StereoOutcome, drift_is_that_of_a_frame_per_second) {
  const Outcome outcome = outcome_of(run_along_truth(0.002), dataset_of(true));
  EXPECT_NEAR(outcome.per_frame.rpe_m_per_s, 0.02, 2e-4) << "2 mm each 0.1 s";
  EXPECT_LT(outcome.per_frame.roe_deg_per_s, 1e-5);
  EXPECT_LT(outcome.per_second.rpe_m_per_s, 2e-4) << "it comes back after two";
  EXPECT_GT(outcome.per_frame.ate_m, 1e-4);
}

TEST(StereoOutcome, counts_and_times_are_means_of_a_frame) {
  OdometryRun run = run_along_truth();
  run.frames[3].result.status = FrameStatus::predicted;
  run.frames[4].result.status = FrameStatus::predicted;
  run.frames[5].result.efficiency = 0.8;
  run.frames[6].result.efficiency = 0.9;
  run.frames[7].features += 15;
  run.frames[7].result.ms.selection += 15;
  const Outcome outcome = outcome_of(run, dataset_of(true));
  EXPECT_NEAR(outcome.tracked_percent, 100.0 * 13 / 15, 1e-9);
  EXPECT_NEAR(outcome.features, 501, 1e-9);
  EXPECT_NEAR(outcome.searched, 300, 1e-9);
  EXPECT_NEAR(outcome.matches, 5, 1e-9);
  EXPECT_NEAR(outcome.inliers, 4, 1e-9);
  EXPECT_NEAR(outcome.selected, 2, 1e-9);
  EXPECT_NEAR(outcome.efficiency, 0.85, 1e-9) << "of the frames that have one";
  EXPECT_NEAR(outcome.ms_base, 10 + 1 + 3 + 6 + 7, 1e-9)
      << "extraction, coarse pose, outlier rejection, what keyframes match besides, mapping";
  EXPECT_NEAR(outcome.ms_matching, 2, 1e-9);
  EXPECT_NEAR(outcome.ms_selection, 4 + 1, 1e-9);
  EXPECT_NEAR(outcome.ms_pose_optimization, 5, 1e-9);
  EXPECT_NEAR(outcome.ms_total(), 27 + 2 + 5 + 5, 1e-9);
  EXPECT_TRUE(std::isnan(outcome_of(run_along_truth(), dataset_of(true)).efficiency)) << "no frame has one";
}

std::set<std::string> keys_of(const nlohmann::ordered_json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

TEST(StereoReport, json_has_the_keys_that_are_promised) {
  const Outcome outcome = outcome_of(run_along_truth(0.001), dataset_of(true));
  Summary unbounded = summary_of("inl", {outcome, outcome});
  unbounded.contestant.budget.reset();
  const auto list =
      nlohmann::ordered_json::parse(stereo_odometry::to_json({summary_of("md", {outcome}), unbounded}).dump());
  ASSERT_TRUE(list.is_array());
  ASSERT_EQ(list.size(), 2U);
  const auto& entry = list[0];
  EXPECT_EQ(keys_of(entry),
            std::set<std::string>(
                {"selector", "budget",      "scale",          "rigid_rpe_m_per_s", "rpe_of_inl", "roe_of_inl",
                 "ate_m",    "rpe_m_per_s", "roe_deg_per_s",  "tracked_percent",   "ms",         "ms_matching_the_rest",
                 "windows",  "runs",        "rpe_1s_m_per_s", "roe_1s_deg_per_s",  "searched",   "matches",
                 "inliers",  "selected",    "efficiency"}));
  EXPECT_EQ(keys_of(entry.at("ms")),
            std::set<std::string>({"base", "matching", "selection", "pose_optimization", "total"}));
  EXPECT_EQ(entry.at("selector"), "md");
  EXPECT_EQ(entry.at("budget"), 100);
  EXPECT_EQ(entry.at("runs"), 1);
  EXPECT_NEAR(entry.at("rpe_m_per_s"), 0.01, 1e-4);
  EXPECT_NEAR(entry.at("tracked_percent"), 100, 1e-9);
  const auto& ms = entry.at("ms");
  EXPECT_NEAR(ms.at("total"),
              static_cast<double>(ms.at("base")) + static_cast<double>(ms.at("matching")) +
                  static_cast<double>(ms.at("selection")) + static_cast<double>(ms.at("pose_optimization")),
              1e-9);
  EXPECT_TRUE(entry.at("efficiency").is_null()) << "none was measured";
  EXPECT_TRUE(list[1].at("budget").is_null());
  EXPECT_EQ(list[1].at("runs"), 2);
  EXPECT_NEAR(entry.at("rpe_of_inl").at("mean"), 1, 1e-9) << "it is the same run";
}

TEST(StereoReport, errors_are_means_of_runs_and_times_medians) {
  std::vector<Outcome> runs(3);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto x = static_cast<double>(i == 2 ? 6 : i);  // mean 7/3, median 1
    runs[i].per_frame.ate_m = runs[i].per_frame.rpe_m_per_s = runs[i].per_frame.roe_deg_per_s = x;
    runs[i].ms_base = runs[i].ms_matching = x;
  }
  const auto entry = stereo_odometry::to_json({summary_of("md", runs)})[0];
  for (const char* const key : {"ate_m", "rpe_m_per_s", "roe_deg_per_s"}) EXPECT_NEAR(entry[key], 7.0 / 3, 1e-12);
  EXPECT_EQ(entry.at("ms").at("base"), 1);
  EXPECT_EQ(entry.at("ms").at("total"), 2);
}

TEST(StereoReport, ratios_to_inl_are_of_the_same_run_with_their_range) {
  const auto runs = [](const std::vector<double>& errors) {
    std::vector<Outcome> outcomes(errors.size());
    for (std::size_t i = 0; i < errors.size(); ++i) outcomes[i].per_frame.rpe_m_per_s = errors[i];
    return outcomes;
  };
  const auto ratio = stereo_odometry::to_json({summary_of("md", runs({2, 8})), summary_of("inl", runs({1, 2}))})[0];
  EXPECT_NEAR(ratio.at("rpe_of_inl").at("mean"), std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(ratio.at("rpe_of_inl").at("low"), 2, 1e-12);
  EXPECT_NEAR(ratio.at("rpe_of_inl").at("high"), 4, 1e-12);
  const auto alone = stereo_odometry::to_json({summary_of("md", runs({2, 8}))})[0];
  EXPECT_TRUE(alone.at("rpe_of_inl").at("mean").is_null()) << "nothing to compare with";
}

TEST(StereoReport, without_truth_errors_are_null_and_a_dash) {
  const Outcome outcome = outcome_of(run_along_truth(), dataset_of(false));
  EXPECT_TRUE(std::isnan(outcome.per_frame.ate_m) && std::isnan(outcome.per_second.rpe_m_per_s));
  EXPECT_TRUE(outcome.per_frame.drifts.empty());
  const std::vector<Summary> all = {summary_of("md", {outcome}), summary_of("inl", {outcome})};
  const auto entry = to_json(all)[0];
  for (const char* const key : {"ate_m", "rpe_m_per_s", "roe_deg_per_s", "rpe_1s_m_per_s", "roe_1s_deg_per_s"}) {
    EXPECT_TRUE(entry[key].is_null()) << key;
  }
  EXPECT_EQ(entry.dump().find("nan"), std::string::npos);
  const Row row = summary_table(all).rows.at(0);
  EXPECT_EQ(Row(row.begin() + 1, row.begin() + 5), Row({"-", "-", "-", "-"}));
}

TEST(StereoReport, frame_table_has_a_row_for_each_frame) {
  OdometryRun run = run_along_truth();
  FrameResult& result = run.frames[2].result;
  result.status = FrameStatus::predicted;
  result.is_keyframe = true;
  result.log_det = 12.5;
  const sim::Table table = frame_table(run);
  const Row expected = {"2",      "0.2",    "predicted", "1",      "500",    "300",     "5",
                        "4",      "2",      "2",         "12.5",   "nan",    "10.0000", "1.0000",
                        "2.0000", "3.0000", "4.0000",    "5.0000", "6.0000", "7.0000"};
  EXPECT_EQ(table.rows.at(2), expected) << testing::PrintToString(table.header);
  EXPECT_EQ(table.rows.at(0)[2], "initialized");
  EXPECT_EQ(table.rows.at(1)[2], "tracked");
}

TEST(StereoReport, kitti_lines_read_back_as_the_same_poses) {
  const OdometryRun run = run_along_truth(0.001);
  std::istringstream lines(to_kitti(run));
  std::string line;
  for (std::size_t i = 0; i < frames; ++i) {
    ASSERT_TRUE(std::getline(lines, line));
    std::istringstream numbers(line);
    const Pose T_wc = run.frames[i].result.T_cw.inverse();
    for (int n = 0; n < 12; ++n) {
      std::string number;
      ASSERT_TRUE(numbers >> number);
      EXPECT_EQ(std::stod(number), T_wc.matrix()(n / 4, n % 4)) << line;
    }
    std::string more;
    EXPECT_FALSE(numbers >> more) << line;
  }
  EXPECT_FALSE(std::getline(lines, line)) << line;
}

TEST(StereoReport, overlay_marks_selected_unselected_and_outliers) {
  const cv::Mat image(200, 600, CV_8UC1, cv::Scalar(128));
  FrameResult result = run_along_truth().frames[1].result;
  fill_lists(result);
  for (std::size_t i = 0; i < 5; ++i) {
    result.matches[i].u = 100 * static_cast<double>(i) + 50.3;
    result.matches[i].v = 120;
  }
  const cv::Mat picture = stereo_odometry::overlay(image, result);
  ASSERT_EQ(picture.size(), image.size());
  ASSERT_EQ(picture.type(), CV_8UC3);
  const auto at = [&](std::size_t i, int dx) {
    return picture.at<cv::Vec3b>(120, 100 * static_cast<int>(i) + 50 + dx);
  };
  const cv::Vec3b background = picture.at<cv::Vec3b>(0, 0), black(0, 0, 0);
  EXPECT_EQ(background[0], background[2]) << "grey";
  EXPECT_LT(background[0], 128) << "darker than the image";
  EXPECT_NE(at(0, 0), background);
  EXPECT_EQ(at(0, 5), background) << "a small dot";
  EXPECT_NE(at(2, 4), background) << "a large one";
  EXPECT_EQ(at(2, 0), at(2, 3));
  EXPECT_NE(at(2, 0), at(0, 0)) << "in another colour";
  EXPECT_EQ(at(1, 0), black) << "a cross on top";
  EXPECT_EQ(at(1, 5), at(2, 5)) << "of the same dot";
  EXPECT_EQ(at(3, 0), at(0, 0)) << "a cross";
  EXPECT_EQ(at(3, 2), background) << "without a dot";
  EXPECT_EQ(at(0, 20), background);
  EXPECT_EQ(image.at<unsigned char>(120, 250), 128) << "the image stays as it is";

  result = FrameResult();  // a frame without matches, and matches far outside
  EXPECT_EQ(stereo_odometry::overlay(image, result).size(), image.size());
  result.matches.resize(1);
  result.matches[0].u = -1e4;
  EXPECT_EQ(stereo_odometry::overlay(image, result).size(), image.size());
}

// The rendered world's camera looks along z and moves to the right, x: from above without y.
TEST(StereoReport, trajectories_begin_at_the_true_pose) {
  const std::vector<stereo_odometry::Contestant> contestants = {summary_of("md", {}).contestant,
                                                                summary_of("inl", {}).contestant};
  OdometryRun standing = run_along_truth();
  for (stereo_odometry::FrameRecord& frame : standing.frames) frame.result.T_cw = Pose(Eigen::Translation3d(1, 2, 3));
  for (const bool has_truth : {false, true}) {
    const auto json = trajectories_to_json(contestants, {run_along_truth(0.01), standing}, dataset_of(has_truth));
    EXPECT_EQ(json.at("dataset"), "it's_made");
    EXPECT_EQ(json.at("axes").dump(), "[\"z (m)\",\"x (m)\"]");
    ASSERT_EQ(json.at("truth").size(), has_truth ? frames : 0U);
    ASSERT_EQ(json.at("trajectories").size(), 2U);
    for (const std::size_t c : {0U, 1U}) {
      const auto& one = json.at("trajectories")[c];
      EXPECT_EQ(one.at("selector"), contestants[c].selector);
      EXPECT_EQ(one.at("name"), contestants[c].name);
      ASSERT_EQ(one.at("points").size(), frames);
      const bool is_moved = has_truth || c == 0;  // the first run begins at the truth
      const Eigen::Vector3d start = is_moved ? RenderedWorld::T_wc(0).translation() : Eigen::Vector3d(-1, -2, -3);
      EXPECT_NEAR(one.at("points")[0][0], start.z(), 1e-12);
      EXPECT_NEAR(one.at("points")[0][1], start.x(), 1e-12);
    }
    EXPECT_EQ(json.at("trajectories")[1].at("points").front(), json.at("trajectories")[1].at("points").back())
        << "it stands";
    EXPECT_NE(json.at("trajectories")[0].at("points").front(), json.at("trajectories")[0].at("points").back());
  }
}

}  // namespace
}  // namespace maxlogdet::test
