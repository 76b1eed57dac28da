// SPDX-License-Identifier: MIT
// `maxlogdet evaluate`, from outside.
#include "bench/does_it_help/evaluation.hpp"
#include "bench/does_it_help/report.hpp"
#include "bench/world/frame_reader.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/program.hpp"

#include <maxlogdet/frame_recorder.hpp>

#include <map>
#include <set>
#include <sstream>

namespace maxlogdet::test {
namespace {

using Json = nlohmann::json;

// As a tracker records it.
void record(const Frame& frame, FrameRecorder& recorder) {
  FrameDetails details;
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
  for (const Match& from : frame.matches) {
    const double uv[2] = {from.u, from.v};
    FeatureMatch match(from.point, uv, 1 / std::sqrt(from.inv_sigma2));
    if (from.is_stereo()) match.u_right = from.u_right;
    match.depth = from.depth;
    match.point_id = from.map_point_id;
    match.camera_id = from.camera_id;
    ASSERT_TRUE(recorder.add(match, from.is_selected, from.desc_dist));
  }
  ASSERT_TRUE(recorder.finish());
}

class Evaluate : public Program {
 protected:
  // Independent errors, so that selection pays.
  void write_recording(const std::string& folder, std::size_t frames, FrameKind kind = FrameKind::stereo) const {
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
      record(frame, recorder);
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
    if (row.at("selector") == selector && row.at("budget") == budget) return row;
  }
  ADD_FAILURE() << "no row of " << selector << ' ' << budget;
  return evaluation.at("selectors")[0];
}

TEST_F(Evaluate, prints_one_object_with_the_keys_of_the_page) {
  write_recording("frames", 12);
  const Json json = evaluated("frames --budgets 30,60");
  EXPECT_EQ(keys_of(json),
            (std::set<std::string>{"frames", "frames_unusable", "matches", "inliers", "verdict", "recommended",
                                   "shares_errors", "chi2_by_leverage", "chi2_by_leverage_intervals",
                                   "cell_correlation", "cell_correlation_interval", "cell_correlation_selected",
                                   "cell_correlation_selected_interval", "cell_correlation_static", "selectors"}));
  EXPECT_EQ(json.at("frames"), 12);
  EXPECT_EQ(json.at("recommended"), "md");
  EXPECT_EQ(json.at("chi2_by_leverage_intervals").size(), 10U);
  EXPECT_TRUE(json.at("cell_correlation_static").is_null()) << "too few frames";

  std::map<std::string, std::set<int>> budgets;
  for (const Json& row : json.at("selectors")) {
    budgets[row.at("selector")].insert(row.at("budget").get<int>());
    EXPECT_EQ(row.at("frames"), 12);
    const bool draws = row.at("selector") == "random" || row.at("selector") == "bucket";
    for (const char* const part : {"translation_mm", "rotation_mrad"}) {
      const Json& deviation = row[part];
      EXPECT_EQ(keys_of(deviation), (std::set<std::string>{"median", "low", "high", "p90", "predicted", "predicted_p90",
                                                           "ratio", "ratio_low", "ratio_high"}));
      EXPECT_NEAR(deviation.at("ratio").get<double>(),
                  deviation.at("median").get<double>() / deviation.at("predicted").get<double>(), 1e-9);
    }
    for (const char* const worth : {"worth_random", "worth_bucket"}) {
      EXPECT_EQ(row.contains(worth), !draws) << row.at("selector");
    }
    EXPECT_EQ(row.at("truth").at("steps"), 11);
  }
  for (const char* const name : {"md", "md_cells", "md_spread", "bucket", "random", "quality"}) {
    EXPECT_EQ(budgets[name], (std::set<int>{30, 60})) << name;
  }
  EXPECT_EQ(budgets.at("own").size(), 1U) << "of the tracker's own number";
  EXPECT_EQ(budgets.size(), 7U);
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
    EXPECT_EQ(row_of(other, "md", 30).at("translation_mm").at("median"),
              row_of(json, "md", 30).at("translation_mm").at("median"));
  }
}

TEST_F(Evaluate, says_the_verdict_first_and_then_shows_the_tables) {
  write_recording("frames", 12);
  write_frame("frame_200.csv", 5);
  const Outcome outcome = run("evaluate frames --budgets 30,60 --repeats 2");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.out.rfind("Max-logDet pays: 60 of your matches give the pose that ", 0), 0U) << outcome.out;
  for (const char* const text : {"13 frames", "(1 frames without a pose left out)", "160 matches",
                                 "Chi-squared by leverage", "| md ", "| random ", "worth random"}) {
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
  EXPECT_EQ(row_of(both, "md", 30).at("truth").at("steps"), 10) << "no step leads from one recording to the next";
  EXPECT_EQ(evaluated("frames/frame_*.csv more --budgets 30"), both);
  EXPECT_EQ(evaluated("frames more/frame_*.csv --budgets 30"), both);
  EXPECT_EQ(evaluated("frames/frame_000003.csv --budgets 30").at("frames"), 1);
}

TEST_F(Evaluate, weighs_errors_of_the_map_if_frames_have_covariances_or_if_told_to) {
  write_recording("frames", 5);
  const Json plain = evaluated("frames --budgets 30");
  const Json weighed = evaluated("frames --budgets 30 --weighting measurement_and_map --map-sigma 0.1");
  EXPECT_GT(row_of(weighed, "md", 30).at("translation_mm").at("predicted"),
            row_of(plain, "md", 30).at("translation_mm").at("predicted"));
  for (const auto& file : std::filesystem::directory_iterator(path("frames"))) {
    std::istringstream lines(text_of(file.path()));
    std::ofstream stream(file.path());
    bool is_header = true;
    for (std::string line; std::getline(lines, line);) {
      const bool is_comment = line[0] == '#';
      stream << line
             << (is_comment  ? ""
                 : is_header ? ",cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz"
                             : ",0.01,0,0,0.01,0,0.01")
             << '\n';
      is_header = is_header && is_comment;
    }
  }
  const Json given = evaluated("frames --budgets 30");
  EXPECT_NEAR(row_of(given, "md", 30).at("translation_mm").at("predicted").get<double>(),
              row_of(weighed, "md", 30).at("translation_mm").at("predicted").get<double>(), 1e-6);
  EXPECT_EQ(evaluated("frames --budgets 30 --weighting measurement"), plain);
}

TEST_F(Evaluate, writes_its_files) {
  write_recording("frames", 5);
  const Json json = evaluated("frames --budgets 30,60 --output results/today");
  EXPECT_EQ(Json::parse(text_of(path("results/today/evaluation.json"))), json);
  const std::string deviation = text_of(path("results/today/deviation.csv"));
  EXPECT_EQ(deviation.rfind("selector,budget,frames,translation_mm,", 0), 0U) << deviation;
  EXPECT_EQ(static_cast<std::size_t>(std::count(deviation.begin(), deviation.end(), '\n')),
            1 + json.at("selectors").size());
  const std::string leverage = text_of(path("results/today/leverage.csv"));
  EXPECT_EQ(leverage.rfind("decile,chi2,low,high\n1,", 0), 0U) << leverage;
  EXPECT_EQ(std::count(leverage.begin(), leverage.end(), '\n'), 11);
}

TEST_F(Evaluate, refuses_frames_that_it_cannot_read) {
  write_recording("frames", 3);
  std::filesystem::create_directories(path("empty"));
  write_frame("frame_few.csv", 5);
  std::filesystem::rename(path("frames/frame_few.csv"), path("frame_few.csv"));
  std::ofstream(path("frames/frame_000001.csv"), std::ios::app) << "1,2,oops\n";
  const std::pair<const char*, const char*> refusals[] = {
      {"", "FRAMES"},
      {" nowhere", "nowhere: cannot be opened; expected a folder of frame_*.csv, or such files"},
      {" frames ./frames/", "./frames/: is given twice"},
      {" frames/frame_000000.csv nowhere.csv", "nowhere.csv: cannot be opened"},
      {" empty", "empty: expected files named frame_*.csv"},
      {" ''", "a value is missing"},
      {" frames", "frames/frame_000001.csv:166: expected 11 fields"},
      {" frames --json --output results", "frames/frame_000001.csv:166: expected 11 fields"},
      {" frame_few.csv", "no frame has 10 matches that agree with one pose; expected"}};
  for (const auto& [arguments, message] : refusals) {
    expect_refused(run("evaluate" + std::string(arguments)), message);
  }
}

// Of ORB-SLAM2's recorded frames: independent errors of the modelled size, 100 selected are worth some 200 random.
class RealFrames : public Evaluate {};

TEST_F(RealFrames, of_orb_slam2_say_that_max_logdet_pays) {
  const std::string frames = data_folder() + "/orb_slam2_frames";
  if (!std::filesystem::is_directory(frames)) GTEST_SKIP() << no_real_frames;
  const Json json = evaluated("'" + frames + "' --budgets 30,100,200");
  EXPECT_NE(json.at("verdict").get<std::string>().find("Max-logDet pays"), std::string::npos) << json.at("verdict");
  EXPECT_GT(row_of(json, "md", 100).at("worth_random"), 150);
  EXPECT_LT(row_of(json, "md", 100).at("worth_random"), 260);
  EXPECT_LT(std::abs(json.at("cell_correlation").get<double>()), 0.06);
  for (const Json& chi2 : json.at("chi2_by_leverage")) EXPECT_NEAR(chi2.get<double>(), 1.1, 0.45);
  for (const int budget : {30, 100, 200}) {
    for (const char* const part : {"translation_mm", "rotation_mrad"}) {
      EXPECT_LT(row_of(json, "md", budget)[part].at("high"), row_of(json, "random", budget)[part].at("median"));
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
