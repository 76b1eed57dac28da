// SPDX-License-Identifier: MIT
// The program and its commands `select` and `evaluate`, from outside: what they answer, write, draw and refuse.
#include "tests/support/program.hpp"
#include "bench/world/frame_reader.hpp"
#include "cli/evaluation.hpp"
#include "cli/report.hpp"
#include "kernel/frame_recorder.hpp"
#include "tests/bench/simulated_frames.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace maxlogdet::test {
namespace {

using Json = nlohmann::json;

TEST_F(Program, prints_a_json_object_for_each_frame_with_the_librarys_answer) {
  write_frame("frame_001.csv", 150);
  write_frame("frame_002.csv", 30);
  run_script(
      "sed -i -e '/^mp_id/s/$/,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz/' "
      "-e '/^[0-9]/s/$/,.0025,0,0,.0025,0,.0025/' frames/*.csv");
  for (const std::string& strategy : sim::names_of(sim::strategies)) {
    const std::string draws = strategy == "stochastic_greedy" ? " --seed 5 --epsilon 0.2" : "";
    for (const BlockKind& kind : block_kinds) {
      const std::string of_blocks = std::string(kind.depth_cue == DepthCue::stereo ? " --stereo" : "") +
                                    (kind.has_covariances ? "" : " --ignore-covariances");
      const auto objects = run_json("select --input frames --budget 40 --strategy " + strategy + draws + of_blocks);
      const auto frames = sim::read_frames(path("frames"));
      ASSERT_EQ(objects.size(), 2U);
      for (std::size_t i = 0; i < 2; ++i) {
        Options options(std::min<std::size_t>(40, frames[i].matches.size()));
        options.stochastic.seed = 5;
        options.stochastic.epsilon = 0.2;
        options.strategy = sim::find_named(sim::strategies, strategy).value();
        const auto expected = select_indices(blocks_of(frames[i], kind), options);
        const auto& object = objects[i];
        EXPECT_EQ(object.at("frame"), frames[i].name);
        EXPECT_EQ(object.at("candidates"), frames[i].matches.size());
        EXPECT_EQ(object.at("budget"), 40);
        EXPECT_EQ(object.at("status"), i == 0 ? "ok" : "all_selected");
        EXPECT_EQ(object.at("strategy"), strategy);
        EXPECT_EQ(object.at("isa"), active_isa());
        EXPECT_EQ(object.at("indices").get<std::vector<std::uint32_t>>(), expected);
        EXPECT_EQ(object.at("gains").size(), expected.size());
        EXPECT_TRUE(object.at("log_det").is_number());
        for (std::size_t j = 0; j < expected.size(); ++j) {
          EXPECT_EQ(object.at("ids")[j], frames[i].matches[expected[j]].map_point_id);
        }
        const auto& latency = object.at("latency_us");
        EXPECT_GT(latency.at("median"), 0);
        EXPECT_LE(latency.at("median"), latency.at("p99"));
        EXPECT_LE(latency.at("p99"), latency.at("max"));
      }
    }
  }
}

TEST_F(Program, respects_limits_of_certificate_grid_time_and_target) {
  write_frame("frame_001.csv", 300);
  const sim::Frame frame = sim::read_frames(path("frames")).at(0);
  const std::string select = "select --input frames --budget 200 ";
  const auto full = run_json(select).at(0);
  for (const char* const key : {"upper_bound", "efficiency"}) EXPECT_FALSE(full.contains(key));
  EXPECT_EQ(full.at("threads"), 1);
  const auto certified = run_json(select + "--certify --threads 2").at(0);
  EXPECT_GE(certified.at("upper_bound"), certified.at("log_det"));
  EXPECT_GT(certified.at("certified_efficiency"), 0);
  EXPECT_LE(certified.at("certified_efficiency"), 1);
  EXPECT_EQ(certified.at("indices"), full.at("indices"));

  std::map<std::pair<int, int>, int> taken;
  const auto spread = run_json(select + "--grid 4x3 --max-per-cell 2").at(0);
  for (const std::size_t i : spread.at("indices")) {
    const int column = std::min(3, static_cast<int>(frame.matches[i].u / frame.width * 4));
    const int row = std::min(2, static_cast<int>(frame.matches[i].v / frame.height * 3));
    EXPECT_LE(++taken[std::pair(column, row)], 2);
  }
  EXPECT_EQ(taken.size(), 12U);
  const auto late = run_json(select + "--time-limit-ms 0.000001").at(0);
  EXPECT_EQ(late.at("status"), "deadline_reached");
  EXPECT_EQ(late.at("indices").size(), 200U);

  const auto share = run_json(select + "--target-efficiency 0.3").at(0);
  EXPECT_EQ(share.at("status"), "target_reached");
  EXPECT_GE(share.at("efficiency"), 0.3 - 1e-12);
  ASSERT_LT(share.at("indices").size(), 200U);
  EXPECT_TRUE(std::equal(share.at("indices").begin(), share.at("indices").end(), full.at("indices").begin()));
}

// Arguments, and what the output has to hold. Without --input, the frame is a synthetic one.
TEST_F(Program, prints_tables_help_and_version) {
  std::string isas;
  for (const std::string& isa : sim::built_in_isas()) isas += " " + isa;
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {"select --repeat 3", {"euroc_like_1", "2000", "200", "ok", "median", "p99", "log det"}},
      {"select --repeat 1 --target-efficiency 0.1", {"D-efficiency against all candidates"}},
      {"demo", {"465 matches", "100 random", "100 selected", "maxlogdet's pose()"}},
      {"--help", {"select", "evaluate", "demo"}},
      {"--version",
       {"maxlogdet " + std::string(version()), isas, std::string("active:                     ") + active_isa(),
        "threads"}}};
  for (const auto& [arguments, texts] : cases) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments;
    EXPECT_EQ(outcome.err, "") << arguments;
    for (const std::string& text : texts) EXPECT_NE(outcome.out.find(text), std::string::npos) << text << outcome.out;
    const Outcome full =
        run_script(MAXLOGDET_PROGRAM " " + std::string(arguments) + " >/dev/full 2>err.txt </dev/null");
    EXPECT_EQ(full.exit_code, 2) << arguments;
    EXPECT_EQ(full.err, "maxlogdet: standard output could not be written\n") << arguments;
  }
}

// Options, their bad values, and a part of the error.
TEST_F(Program, refuses_invalid_arguments) {
  write_frame("frame_001.csv", 20);
  std::filesystem::create_directories(path("folder.json"));
  const struct {
    std::string option;
    std::vector<std::string> values;
    std::string message;
  } refusals[] = {
      {"", {""}, "select, evaluate, demo"},
      {"selct", {""}, "selct"},
      {"select", {"--bogus"}, "--bogus"},
      {"select --budget", {"", "-1", "1.5", "99999999999999999999"}, "--budget"},
      {"select --strategy", {"best"}, "best"},
      {"select --input", {"."}, "found none"},
      {"select --input", {"''"}, "--input: a value is missing"},
      {"select --input=", {""}, "--input"},
      {"select --input", {"'two\nlines'"}, "two?lines: cannot be opened"},
      {"demo --plot-data", {"picture.svg"}, "ends in .json"},
      {"demo --plot-data", {"folder.json"}, "is a folder"},
      {"demo --plot-data", {"nowhere/picture.json"}, "nowhere/picture.json: cannot be written"},
      {"select --repeat", {"0"}, "--repeat"},
      {"select --threads", {"-1"}, "--threads"},
      {"select --max-per-cell", {"-1"}, "--max-per-cell"},
      {"evaluate frames --threads", {"-1"}, "--threads"},
      {"select --grid", {"8", "8x", "x6", "0x6", "8x0", "8x6x2", "1001x1", "-1x3", "ax6"}, "--grid"},
      {"select --time-limit-ms", {"-1", "nan"}, "--time-limit-ms"},
      {"select --strategy stochastic_greedy --epsilon", {"0", "1", "-1", "nan", "inf"}, "0 < epsilon < 1"},
      {"select --strategy stochastic_greedy --seed",
       {"x", "-1", "' -1'", "18446744073709551616", "99999999999999999999999", "1e3"},
       "--seed '"},
      {"select --input frames --map-sigma", {"-1", "inf", "nan"}, "a finite --map-sigma of 0 or more"},
      {"select --target-efficiency", {"1.1", "-1", "inf", "nan"}, "expected 0 (none) to 1"},
      {"select --input frames --max-per-cell", {"2"}, "--max-per-cell does nothing here; expected with it --grid"},
      {"select --input frames --epsilon", {"0.2"}, "--epsilon does nothing here; expected with it --strategy st"},
      {"select --input frames --seed", {"3"}, "--seed does nothing here; expected with it --strategy stochastic_gr"},
      {"select --map-sigma", {"0.1"}, "--map-sigma does nothing here; expected with it --input"},
      {"select --input frames --ignore-covariances --map-sigma", {"0.1"}, "excludes"},
      {"evaluate frames --ignore-covariances --map-sigma", {"0.1"}, "excludes"},
      {"evaluate frames --map-sigma", {"-1", "inf", "nan"}, "--map-sigma: expected a finite number of 0 or more"},
      {"evaluate frames --budgets", {"5", "0", "-30", "ten"}, "--budgets"},
      {"evaluate frames --repeats", {"0", "1001"}, "--repeats"},
      {"evaluate frames --seed", {"x"}, "--seed"}};
  for (const auto& [option, values, message] : refusals) {
    for (const std::string& value : values) {
      SCOPED_TRACE(option + " " + value);
      expect_refused(run(option + " " + value), message);
    }
  }
  const std::string ends = "--input frames --map-sigma 0.1 --seed 18446744073709551615";
  EXPECT_EQ(run("select --repeat 1 --strategy stochastic_greedy " + ends).exit_code, 0);
  for (const char* const command : {"select", "evaluate frames", "demo"}) {
    expect_refused(run(command, "MAXLOGDET_ISA=avx1024 "), "MAXLOGDET_ISA is 'avx1024'; expected one that");
  }
  write_frame("frame_002.csv", 50, "7,1,2,oops,4,5,-1,1\n");  // nothing is printed of the frame before it
  for (const char* const select : {"select --input frames", "select --input frames --json"}) {
    expect_refused(run(select), "frames/frame_002.csv:55: expected a finite number for Z, not 'oops'");
  }
}

// A file is either complete or unchanged.
TEST_F(Program, leaves_no_partial_file) {
  const std::string demo = "demo --plot-data ";
  std::ofstream(path("old.json")) << "old data\n";
  // In blocks of 512 bytes, in some shells 1024; the data has about 25 KB.
  const auto limited = [&](const std::string& file) {
    return run_script("ulimit -f 4\n" MAXLOGDET_PROGRAM " " + demo + file + " >out.txt 2>err.txt </dev/null");
  };
  expect_refused(limited("new.json"), "new.json: cannot be written (File too large)");
  EXPECT_FALSE(std::filesystem::exists(path("new.json")));
  expect_refused(limited("old.json"), "old.json: cannot be written (File too large)");
  EXPECT_EQ(text_of(path("old.json")), "old data\n");

  std::filesystem::create_symlink("/dev/full", path("full.json"));
  expect_refused(run(demo + "full.json"), "full.json: cannot be written (No space left on device)");
  EXPECT_TRUE(std::filesystem::is_symlink(path("full.json")));
  expect_refused(run(demo + std::string(300, 'a') + ".json"), "a.json: cannot be written");

  std::filesystem::create_symlink("old.json", path("link.json"));
  EXPECT_EQ(run(demo + "link.json").exit_code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(path("link.json")));
  EXPECT_EQ(Json::parse(text_of(path("old.json"))).at("u_px").size(), 465U);
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    EXPECT_NE(entry.path().extension(), ".new") << entry.path();
  }
}

TEST_F(Program, warns_of_what_a_frame_lacks_and_counts_candidates_without_a_block) {
  const std::string good =
      "# fx,fy,cx,cy,bf: 400,400,376,240,50\n# image width,height: 752,480\n# Tcw_prior: "
      "1,0,0,0,0,1,0,0,0,0,1,0\nmp_id,X,Y,Z,u,v,u_right\n1,5,1,3,296,240,280\n2,5,0,-1,376,160,-1\n";
  const auto run_with = [&](const std::string& old, const std::string& text, const std::string& options) {
    std::ofstream(path("frame.csv")) << std::string(good).replace(good.find(old), old.size(), text);
    return run("select --input frame.csv --json " + options);
  };
  EXPECT_EQ(run_with(",50", ",0", "").exit_code, 0);
  expect_refused(run_with(",50", ",0", "--stereo"), "bf > 0");
  const Outcome misspelt = run_with("u_right", "uR", "--stereo");
  EXPECT_EQ(misspelt.exit_code, 0);
  EXPECT_NE(misspelt.err.find("unknown column 'uR'"), std::string::npos) << misspelt.err;
  EXPECT_NE(misspelt.err.find("no match has a right-image column"), std::string::npos) << misspelt.err;
  const auto behind = Json::parse(misspelt.out);
  EXPECT_EQ(behind.at("status"), "all_selected");
  EXPECT_EQ(behind.at("invalid_candidates"), 1) << "behind the camera";
  EXPECT_EQ(behind.at("indices").size(), 1U);
}

// What ./ci/demo shows: the library's own claim, on frames with wrong matches.
TEST_F(Program, demonstrates_that_selected_matches_are_right_and_near_the_pose_of_all) {
  EXPECT_EQ(run("demo --plot-data \"it's.json\"").exit_code, 0);
  const Json data = Json::parse(text_of(path("it's.json")));
  const auto wrong_of = [&](const Json& choice) {
    std::size_t wrong = 0;
    for (const std::size_t i : choice.at("matches")) wrong += data.at("is_wrong")[i].get<bool>() ? 1 : 0;
    return wrong;
  };
  const Json& choices = data.at("choices");
  ASSERT_EQ(choices.size(), 4U);
  const Json &all = choices[0], &random = choices[1], &selected = choices[2], &aligned = choices[3];
  EXPECT_EQ(all.at("matches").size(), 465U);
  EXPECT_EQ(random.at("matches").size(), 100U);
  EXPECT_EQ(selected.at("matches").size(), 100U);
  EXPECT_GT(wrong_of(all), 30U);
  EXPECT_GT(wrong_of(random), wrong_of(selected));
  EXPECT_LT(wrong_of(aligned), wrong_of(all) / 4);
  EXPECT_EQ(all.at("position_error"), 1);
  EXPECT_LT(aligned.at("position_error"), 1.1);
  EXPECT_LT(selected.at("position_error").get<double>(), 0.75 * random.at("position_error").get<double>());

  EXPECT_EQ(draw("\"it's.json\"").out, "drew it's.svg and .png\n");
  EXPECT_EQ(text_of(path("it's.png")).substr(1, 3), "PNG");
  const std::string svg = text_of(path("it's.svg"));
  // gnuplot marks each point by <use xlink:href=... color='rgb(...)'/>.
  const auto count = [&](const std::string& colour) {
    std::size_t marks = 0;
    std::istringstream lines(svg);
    for (std::string line; std::getline(lines, line);) {
      if (line.find("<use") != std::string::npos && line.find("color='" + colour + "'") != std::string::npos) ++marks;
    }
    return marks;
  };
  std::size_t chosen = 0, wrong = 0;
  for (const Json& choice : choices) {
    chosen += choice.at("matches").size();
    wrong += wrong_of(choice);
  }
  EXPECT_LE(count("rgb(255,  48,  32)"), wrong);
  EXPECT_GE(count("rgb(255,  48,  32)"), 0.9 * static_cast<double>(wrong))
      << "wrong ones may be moved out of the image";
  EXPECT_GE(count("rgb(  0, 114, 178)"), 0.95 * static_cast<double>(chosen - wrong));
}

class Evaluate : public Program {
 protected:
  // Frames as a tracker records them, with independent errors, so that selection pays. `variance`: of map points along
  // each axis, m^2; 0: unknown. It is known of every `known_every`-th point.
  void write_recording(const std::string& folder, std::size_t frames, FrameKind kind = FrameKind::stereo,
                       double variance = 0, int known_every = 1) const {
    Random random(static_cast<std::uint64_t>(kind));
    FrameRecorder recorder;
    ASSERT_TRUE(recorder.open(path(folder).c_str()));
    for (std::size_t i = 0; i < frames; ++i) {
      Frame frame = simulated_frame(random, kind, 160);
      add_errors(random, frame);
      const std::vector<Camera>& rig = frame.camera.rig;
      const Camera alone(frame.camera);
      const double covariance[9] = {variance, 0, 0, 0, variance, 0, 0, 0, variance};
      std::vector<FeatureMatch> matches;
      std::vector<unsigned char> is_selected;
      MatchedFrame written;
      written.cameras = rig.empty() ? &alone : rig.data();
      written.camera_count = rig.empty() ? 1 : rig.size();
      written.T_bw = RigidTransform::row_major(frame.T_cw_prior.data());
      if (frame.camera.depth_sigma > 0) written.options.depth_sigma = frame.camera.depth_sigma;
      for (const Match& from : frame.matches) {
        matches.push_back(feature_match(from, frame.camera.depth_cue()));
        matches.back().point_id = from.map_point_id;
        const bool is_known = from.map_point_id % known_every == 0;
        if (variance > 0 && is_known) matches.back().covariance = covariance;
        written.note(matches.back());
        is_selected.push_back(random.chance(0.5) ? 1 : 0);
      }
      written.matches = matches.data();
      written.size = matches.size();
      ASSERT_TRUE(recorder.write(written, is_selected.data()));
      const std::string file = path(folder + "/frame_" + std::to_string(1000000 + i).substr(1) + ".csv");
      const std::string text = text_of(file);
      std::ofstream stream(file);
      stream << "# image width,height: 752,480\n# Tcw_true: " << std::setprecision(17);
      for (std::size_t e = 0; e < 12; ++e) stream << (e > 0 ? "," : "") << (*frame.T_cw_true)[e];
      stream << '\n' << text;
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

  const std::set<std::string> estimate = {"high", "low", "value"},
                              with_prediction = {"high", "low", "predicted", "value"};
  EXPECT_EQ(json.at("selectors").size(), 2U * 6 + 2) << "at each budget, and without: own, aligned";
  for (const Json& row : json.at("selectors")) {
    EXPECT_EQ(row.at("frames"), 12);
    EXPECT_EQ(row.at("true_steps"), 11);
    EXPECT_EQ(keys_of(row.at("wrong_percent")), estimate);
    for (const std::string part : {"translation", "rotation"}) {
      EXPECT_EQ(keys_of(row.at(part + "_growth_percent")), with_prediction);
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
       {"13 frames", "(1 without a pose left out)", "160 matches", "- For the pose alone, do not select, take pose()",
        "Wrong matches", "| md ", "| random ", "| aligned ", "in translation, %", "in rotation, %",
        "Chi-squared by leverage"}) {
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

TEST_F(Evaluate, weighs_errors_of_the_map_if_frames_have_covariances_unless_told_not_to) {
  write_recording("frames", 5);
  write_recording("all_known", 5, FrameKind::stereo, 0.0625);
  write_recording("some_known", 5, FrameKind::stereo, 0.0625, 3);
  const Json plain = evaluated("frames --budgets 30"), weighed = evaluated("all_known --budgets 30");
  EXPECT_GT(weighed.at("translation_sigma_mm"), plain.at("translation_sigma_mm"));
  EXPECT_EQ(evaluated("some_known --budgets 30 --map-sigma 0.25"), weighed);
  EXPECT_NE(evaluated("some_known --budgets 30"), weighed) << "5 cm";
  EXPECT_EQ(evaluated("frames --budgets 30 --map-sigma 0.25"), plain);
  EXPECT_EQ(evaluated("all_known --budgets 30 --ignore-covariances"), plain);
}

TEST_F(Evaluate, refuses_frames_that_it_cannot_read_and_folders_that_it_cannot_write_to) {
  write_recording("frames", 3);
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
      {" ''", "a value is missing"},
      {" frames", "frames/frame_000001.csv:166: expected 10 fields"},
      {" frame_few.csv", "no frame has 10 matches that agree with one pose; expected"},
      {" good --output file/within", "file/within"},
      {" good --output results", "results/evaluation.json"}};
  for (const auto& [arguments, message] : refusals) {
    expect_refused(run("evaluate" + std::string(arguments)), message);
  }
}

TEST_F(Evaluate, warns_about_columns_that_may_be_misspelt) {
  write_recording("frames", 3);
  const Outcome outcome = run_script("sed -i s/inv_sigma2/distance/ frames/*.csv\n" MAXLOGDET_PROGRAM
                                     " evaluate frames --budgets 30 --repeats 1 >out.txt 2>err.txt");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "maxlogdet: frame_000000: ignores the columns distance\n") << "once for a recording";
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
    const Json json = evaluated("'" + data + "/" + known.folder + "' --budgets 30,100");
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
