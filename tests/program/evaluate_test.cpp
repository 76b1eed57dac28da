// SPDX-License-Identifier: MIT
// `maxlogdet evaluate`, from outside.
#include "bench/world/frame_reader.hpp"
#include "cli/evaluation.hpp"
#include "cli/report.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/program.hpp"

#include <maxlogdet/frame_recorder.hpp>

#include <set>
#include <sstream>

namespace maxlogdet::test {
namespace {

using Json = nlohmann::json;

// As a tracker records it. `variance`: of map points along each axis, m^2; 0: unknown.
void record(const Frame& frame, FrameRecorder& recorder, double variance) {
  FrameDetails details;
  details.has_covariances = variance > 0;
  details.depth_cue = frame.camera.depth_cue();
  if (frame.camera.depth_sigma > 0) details.depth_sigma = frame.camera.depth_sigma;
  details.has_descriptor_distances = true;
  details.width = 752;
  details.height = 480;
  details.T_cw_true = RigidTransform::row_major(frame.T_cw_true->data());
  const RigidTransform T_cw = RigidTransform::row_major(frame.T_cw_prior.data());
  const std::vector<Camera>& rig = frame.camera.rig;
  ASSERT_TRUE(rig.empty() ? recorder.start(Camera(frame.camera), T_cw, details)
                          : recorder.start(rig.data(), rig.size(), T_cw, details));
  const double covariance[9] = {variance, 0, 0, 0, variance, 0, 0, 0, variance};
  for (const Match& from : frame.matches) {
    const double uv[2] = {from.u, from.v};
    FeatureMatch match(from.point, uv, 1 / std::sqrt(from.inv_sigma2));
    if (from.is_stereo()) match.u_right = from.u_right;
    match.depth = from.depth;
    match.point_id = from.map_point_id;
    match.camera_id = from.camera_id;
    if (variance > 0) match.covariance = covariance;
    ASSERT_TRUE(recorder.add(match, from.is_selected, from.desc_dist));
  }
  ASSERT_TRUE(recorder.finish());
}

class Evaluate : public Program {
 protected:
  // Independent errors, so that selection pays.
  void write_recording(const std::string& folder, std::size_t frames, FrameKind kind = FrameKind::stereo,
                       double variance = 0) const {
    Random random(static_cast<std::uint64_t>(kind));
    FrameRecorder recorder;
    ASSERT_TRUE(recorder.open(path(folder).c_str()));
    for (std::size_t i = 0; i < frames; ++i) {
      Frame frame = simulated_frame(random, kind, 160);
      add_errors(random, frame);
      for (Match& match : frame.matches) {
        match.desc_dist = random.integer(0, 100);
        match.is_selected = random.chance(0.5);
      }
      record(frame, recorder, variance);
    }
  }

  Json evaluated(const std::string& arguments) const {
    const Outcome outcome = run("evaluate --json --repeats 2 " + arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1) << "one object, one line";
    return outcome.exit_code == 0 ? Json::parse(outcome.out) : Json();
  }
};

std::set<std::string> keys_of(const Json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

const Json& row_of(const Json& evaluation, const std::string& selector, int budget) {
  for (const Json& row : evaluation.at("selectors")) {
    if (row.at("selector") == selector && (budget == 0 || row.at("budget") == budget)) return row;
  }
  ADD_FAILURE() << "no row of " << selector << ' ' << budget;
  return evaluation.at("selectors")[0];
}

TEST_F(Evaluate, prints_and_writes_one_object_with_the_keys_of_the_page) {
  write_recording("frames", 12);
  const Json json = evaluated("frames --budgets 30,60 --output results/today");
  EXPECT_EQ(Json::parse(text_of(path("results/today/evaluation.json"))), json);
  EXPECT_EQ(keys_of(json),
            (std::set<std::string>{"frames", "frames_unusable", "frames_unaligned", "matches", "inliers",
                                   "translation_sigma_mm", "rotation_sigma_mrad", "verdict", "advice", "recommended",
                                   "shares_errors", "chi2", "chi2_by_leverage", "cell_correlation", "selectors"}));
  EXPECT_EQ(json.at("frames"), 12);
  EXPECT_EQ(json.at("recommended"), "md");
  EXPECT_EQ(json.at("chi2_by_leverage").size(), 10U);

  const std::set<std::string> estimate = {"value", "low", "high"};
  EXPECT_EQ(json.at("selectors").size(), 2U * 6 + 2) << "at each budget, and without: own, aligned";
  for (const Json& row : json.at("selectors")) {
    EXPECT_EQ(row.at("frames"), 12);
    EXPECT_EQ(row.at("true_steps"), 11);
    EXPECT_EQ(keys_of(row.at("wrong_percent")), estimate);
    for (const std::string part : {"translation", "rotation"}) {
      EXPECT_EQ(keys_of(row.at(part + "_growth_percent")),
                (std::set<std::string>{"value", "low", "high", "predicted"}));
      EXPECT_EQ(keys_of(row.at(part + "_of_random")), estimate);
      EXPECT_EQ(keys_of(row.at(part + "_true_growth_percent")), estimate);
    }
  }
}

TEST_F(Evaluate, computes_what_the_library_computes_for_every_kind_of_camera) {
  for (const FrameKind kind : frame_kinds) {
    SCOPED_TRACE(to_string(kind));
    const std::string folder = to_string(kind);
    write_recording(folder, 5, kind);
    sim::EvaluationOptions options;
    options.budgets = {30};
    options.repeats = 2;
    options.seed = 9;
    const auto expected = sim::evaluate({sim::read_frames(path(folder))}, options, 1);
    const Json json = evaluated(folder + " --budgets 30 --seed 9 --threads 2");
    EXPECT_EQ(json, Json::parse(to_json(expected).dump()));
    const Json other = evaluated(folder + " --budgets 30 --seed 10");
    EXPECT_NE(row_of(other, "random", 30), row_of(json, "random", 30));
    EXPECT_EQ(row_of(other, "md", 30).at("translation_growth_percent"),
              row_of(json, "md", 30).at("translation_growth_percent"));
  }
}

TEST_F(Evaluate, says_the_verdict_first_then_the_advice_and_then_shows_the_tables) {
  write_recording("frames", 12);
  write_frame("frame_200.csv", 5);
  const Outcome outcome = run("evaluate frames --budgets 30,80 --repeats 2");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(
      outcome.out.rfind("Max-logDet pays: with 80 of some 159 inliers the standard deviation of the pose grows by ", 0),
      0U)
      << outcome.out;
  for (const char* const text :
       {"13 frames", "(1 frames without a pose left out)", "160 matches",
        "- For the pose alone, do not select, take pose()", "Wrong matches", "| md ", "| random ", "| aligned ",
        "in translation, %", "in rotation, %", "Chi-squared by leverage"}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << '\n' << outcome.out;
  }
}

TEST_F(Evaluate, files_of_a_folder_are_its_recording) {
  write_recording("frames", 6);
  const Json of_folder = evaluated("frames --budgets 30");
  EXPECT_EQ(evaluated("frames/frame_*.csv --budgets 30"), of_folder);
  EXPECT_EQ(evaluated("frames/ --budgets 30"), of_folder);
  write_recording("more", 6, FrameKind::monocular);
  const Json both = evaluated("frames more --budgets 30");
  EXPECT_EQ(both.at("frames"), 12);
  EXPECT_EQ(row_of(both, "md", 30).at("true_steps"), 10) << "no step leads from one recording to the next";
  EXPECT_EQ(evaluated("frames/frame_*.csv more --budgets 30"), both);
  EXPECT_EQ(evaluated("frames more/frame_*.csv --budgets 30"), both);
  EXPECT_EQ(evaluated("frames/frame_000003.csv --budgets 30").at("frames"), 1);
}

TEST_F(Evaluate, weighs_errors_of_the_map_if_frames_have_covariances_or_if_told_to) {
  write_recording("frames", 5);
  write_recording("with_covariances", 5, FrameKind::stereo, 0.01);
  const Json plain = evaluated("frames --budgets 30");
  const Json weighed = evaluated("frames --budgets 30 --weighting measurement_and_map --map-sigma 0.1");
  EXPECT_GT(weighed.at("translation_sigma_mm"), plain.at("translation_sigma_mm"));
  const Json given = evaluated("with_covariances --budgets 30");
  EXPECT_NEAR(given.at("translation_sigma_mm").get<double>(), weighed.at("translation_sigma_mm").get<double>(), 1e-6);
  EXPECT_EQ(evaluated("with_covariances --budgets 30 --weighting measurement"), plain);
}

TEST_F(Evaluate, refuses_frames_that_it_cannot_read_and_folders_that_it_cannot_write_to) {
  write_recording("frames", 3);
  std::filesystem::create_directories(path("empty"));
  write_frame("frame_few.csv", 5);
  std::filesystem::rename(path("frames/frame_few.csv"), path("frame_few.csv"));
  write_recording("good", 2);
  std::ofstream(path("frames/frame_000001.csv"), std::ios::app) << "1,2,oops\n";
  std::ofstream(path("file")) << "no folder\n";
  std::filesystem::create_directories(path("results/evaluation.json"));
  const std::pair<const char*, const char*> refusals[] = {
      {"", "FRAMES"},
      {" nowhere", "nowhere: cannot be opened; expected a folder of frame_*.csv, or such files"},
      {" frames ./frames/", "./frames/: is given twice"},
      {" frames/frame_000000.csv nowhere.csv", "nowhere.csv: cannot be opened"},
      {" empty", "empty: expected files named frame_*.csv"},
      {" /dev/zero", "/dev/zero:1: expected a line of at most 65536 bytes"},
      {" ''", "a value is missing"},
      {" frames", "frames/frame_000001.csv:166: expected 11 fields"},
      {" frames --json --output new", "frames/frame_000001.csv:166: expected 11 fields"},
      {" frame_few.csv", "no frame has 10 matches that agree with one pose; expected"},
      {" good --output file", "file"},
      {" good --output file/within", "file/within"},
      {" good --output /proc/results", "/proc/results"},
      {" good --output results", "results/evaluation.json"}};
  for (const auto& [arguments, message] : refusals) {
    expect_refused(run("evaluate" + std::string(arguments)), message);
  }
}

TEST_F(Evaluate, warns_about_columns_that_may_be_misspelt) {
  write_recording("frames", 3);
  const Outcome outcome = run_script("sed -i s/desc_dist/distance/ frames/*.csv\n" MAXLOGDET_PROGRAM
                                     " evaluate frames --budgets 30 --repeats 1 >out.txt 2>err.txt");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "maxlogdet: frame_000000: ignores the columns distance\n") << "once for a recording";
}

std::string frames_of(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().filename().string().rfind("frame_", 0) == 0) files.push_back(file.path().string());
  }
  std::sort(files.begin(), files.end());
  std::string arguments;
  for (std::size_t i = 0; i<files.size(); i += files.size()> 100 ? 2 : 1) arguments += " '" + files[i] + "'";
  return arguments;
}

class RealFrames : public Evaluate {};

// With wrong ones among them, as a prototype in numpy has counted them (in percent): all, the 30 that Max-logDet
// selects without a gate, and those that it selects behind it.
struct WrongMatches {
  const char* folder;
  double all, ungated, gated;
};
constexpr WrongMatches wrong_matches[] = {{"lk_vo_frames_0039", 12, 31, 1.5},
                                          {"orb_slam3_frames_0039", 11, 17, 1.3},
                                          {"orb_slam2_frames_0039", 10, 14, 0.1},
                                          {"orb_slam2_frames", 9, 11, 0.5}};

TEST_F(RealFrames, as_trackers_match_them_hold_wrong_ones_which_the_gate_keeps_out) {
  const std::string data = data_folder();
  if (data.empty()) GTEST_SKIP() << no_real_frames;
  std::size_t found = 0;
  for (const WrongMatches& known : wrong_matches) {
    if (!std::filesystem::is_directory(data + "/" + known.folder)) continue;
    SCOPED_TRACE(known.folder);
    ++found;
    const Json json = evaluated(frames_of(data + "/" + known.folder) + " --budgets 30,100");
    const auto wrong = [&](const char* selector) {
      return row_of(json, selector, 30).at("wrong_percent").at("value").get<double>();
    };
    EXPECT_NEAR(wrong("random"), known.all, 4);
    EXPECT_NEAR(wrong("md_ungated"), known.ungated, 5);
    EXPECT_LT(wrong("md"), known.gated + 1.5);
    EXPECT_LT(std::abs(json.at("cell_correlation").at("value").get<double>()), 0.06);
    for (const Json& chi2 : json.at("chi2_by_leverage")) EXPECT_NEAR(chi2.at("value").get<double>(), 0.7, 0.5);
    for (const char* const part : {"translation_growth_percent", "rotation_growth_percent"}) {
      EXPECT_LT(row_of(json, "aligned", 0).at(part).at("value"), row_of(json, "md", 100).at(part).at("value")) << part;
    }
  }
  if (found == 0) GTEST_SKIP() << "no recorded frames in " << data;
}

}  // namespace
}  // namespace maxlogdet::test
