// SPDX-License-Identifier: MIT
// The program's output and errors.
#include "tests/support/program.hpp"
#include "bench/world/frame_reader.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

namespace maxlogdet::test {
namespace {

std::string upper_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

TEST_F(Program, selects_on_the_embedded_frame) {
  const Outcome outcome = run("select --repeat 3");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* const text : {"euroc_like_1", "2000", "200", "ok", "median", "p99", "log det"}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << '\n' << outcome.out;
  }
}

TEST_F(Program, prints_a_json_object_for_each_frame_with_the_librarys_answer) {
  write_frame("frame_001.csv", 150);
  write_frame("frame_002.csv", 30);
  for (const std::string& strategy : sim::names_of(sim::strategies)) {
    const std::string draws = strategy == "stochastic_greedy" ? " --seed 5 --epsilon 0.2" : "";
    for (const BlockKind& kind : block_kinds) {
      const std::string stereo = kind.depth_cue == DepthCue::stereo ? " --stereo" : "";
      const auto objects = run_json("select --input frames --budget 40 --strategy " + strategy + draws +
                                    " --weighting " + to_string(kind.weighting) + stereo);
      const auto frames = sim::read_frames(path("frames"));
      ASSERT_EQ(objects.size(), 2U);
      for (std::size_t i = 0; i < 2; ++i) {
        Options options;
        options.budget = std::min<std::size_t>(40, frames[i].matches.size());
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
        EXPECT_EQ(object.at("weighting"), to_string(kind.weighting));
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

TEST_F(Program, certifies_and_reports_threads) {
  write_frame("frame_001.csv", 300);
  const auto plain = run_json("select --input frames --budget 8 --certify").at(0);
  EXPECT_GE(plain.at("upper_bound"), plain.at("log_det"));
  EXPECT_GT(plain.at("certified_efficiency"), 0);
  EXPECT_LE(plain.at("certified_efficiency"), 1);
  EXPECT_EQ(plain.at("threads"), 1);
  EXPECT_FALSE(run_json("select --input frames --budget 8").at(0).contains("upper_bound"));
  EXPECT_GE(run_json("select --input frames --budget 250 --threads 2").at(0).at("threads"), 1);
}

TEST_F(Program, respects_a_grid_and_a_time_limit) {
  write_frame("frame_001.csv", 300);
  const sim::Frame frame = sim::read_frames(path("frames")).at(0);
  const auto object = run_json("select --input frames --budget 60 --grid 4x3 --max-per-cell 2").at(0);
  EXPECT_LE(object.at("indices").size(), 24U);
  std::map<std::pair<int, int>, int> taken;
  for (const std::size_t i : object.at("indices")) {
    const int column = std::min(3, static_cast<int>(frame.matches[i].u / frame.width * 4));
    const int row = std::min(2, static_cast<int>(frame.matches[i].v / frame.height * 3));
    ++taken[{column, row}];
  }
  for (const auto& [cell, count] : taken) EXPECT_LE(count, 2);
  const auto late = run_json("select --input frames --budget 60 --time-limit-ms 0.000001").at(0);
  EXPECT_EQ(late.at("status"), "deadline_reached");
  EXPECT_EQ(late.at("indices").size(), 60U);
}

TEST_F(Program, stops_at_targets) {
  write_frame("frame_001.csv", 300);
  const auto full = run_json("select --input frames --budget 200").at(0);
  EXPECT_FALSE(full.contains("efficiency") || full.contains("translation_sigma"));
  const auto share = run_json("select --input frames --budget 200 --target-efficiency 0.3").at(0);
  EXPECT_EQ(share.at("status"), "target_reached");
  EXPECT_GE(share.at("efficiency"), 0.3 - 1e-12);
  EXPECT_FALSE(share.contains("rotation_sigma"));
  const std::size_t size = share.at("indices").size();
  ASSERT_LT(size, 200U);
  EXPECT_TRUE(std::equal(share.at("indices").begin(), share.at("indices").end(), full.at("indices").begin()));
  const std::string options = " --target-translation-sigma 0.05 --target-rotation-sigma 0.01";
  const auto sigmas = run_json("select --input frames --budget 200" + options).at(0);
  EXPECT_EQ(sigmas.at("status"), "target_reached");
  EXPECT_LE(sigmas.at("translation_sigma"), 0.05 + 1e-12);
  EXPECT_LE(sigmas.at("rotation_sigma"), 0.01 + 1e-12);
  const Outcome table = run("select --input frames --repeat 1 --target-efficiency 0.1" + options);
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("D-efficiency against all candidates"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("expected deviation of the rotation"), std::string::npos) << table.out;
}

TEST_F(Program, refuses_a_malformed_row_and_prints_nothing_of_the_frames_before_it) {
  write_frame("frame_001.csv", 50);
  write_frame("frame_002.csv", 50, "7,1,2,oops,4,5,-1,1\n");
  for (const char* const select : {"select --input frames", "select --input frames --json"}) {
    expect_refused(run(select), "frames/frame_002.csv:55: expected a finite number for Z, not 'oops'");
  }
}

// Each with a part of its error.
using Refusals = std::vector<std::pair<std::string, std::string>>;

TEST_F(Program, refuses_invalid_arguments) {
  std::filesystem::create_directories(path("folder.json"));
  const Refusals refusals = {{"", "select, evaluate"},
                             {"selct", "selct"},
                             {"select --bogus", "--bogus"},
                             {"select --budget", "--budget"},
                             {"select --strategy best", "best"},
                             {"select --weighting best", "best"},
                             {"select --input nowhere", "nowhere: cannot be opened"},
                             {"select --input .", "found none"},
                             {"select --input 'two\nlines'", "two?lines: cannot be opened"},
                             {"select --plot-data picture.svg", "ends in .json"},
                             {"select --plot-data folder.json", "is a folder"},
                             {"select --target-efficiency 1.1", "--target-efficiency"}};
  for (const auto& [arguments, message] : refusals) expect_refused(run(arguments), message);
  expect_refused(run("select", "MAXLOGDET_ISA=avx1024 "), "MAXLOGDET_ISA is 'avx1024'; expected one that");
}

// Options, their bad values, and a part of the error.
TEST_F(Program, refuses_invalid_values) {
  write_frame("frame_001.csv", 20);
  const struct {
    std::string option;
    std::vector<std::string> values;
    std::string message;
  } refusals[] = {
      {"select --budget", {"-1", "1.5", "99999999999999999999"}, "--budget"},
      {"select --repeat", {"0"}, "--repeat"},
      {"select --grid", {"8", "8x", "x6", "0x6", "8x0", "8x6x2", "1001x1", "-1x3", "ax6"}, "--grid"},
      {"select --max-per-cell", {"-1"}, "--max-per-cell"},
      {"select --threads", {"-1", "two"}, "--threads"},
      {"select --time-limit-ms", {"-1", "nan"}, "--time-limit-ms"},
      {"select --epsilon", {"x"}, "--epsilon"},
      {"select --strategy stochastic_greedy --epsilon", {"0", "1", "-1", "nan", "inf"}, "0 < epsilon < 1"},
      {"select --strategy stochastic_greedy --seed",
       {"x", "-1", "' -1'", "18446744073709551616", "99999999999999999999999", "1e3"},
       "--seed '"},
      {"select --weighting measurement_and_map --map-sigma", {"-1", "inf", "nan"}, "a finite --map-sigma of 0 or more"},
      {"evaluate frames --map-sigma", {"-1", "inf", "nan"}, "--map-sigma: expected a finite number of 0 or more"},
      {"evaluate frames --budgets", {"5", "0", "-30", "ten"}, "--budgets"},
      {"evaluate frames --repeats", {"0", "1001"}, "--repeats"},
      {"evaluate frames --weighting", {"map_bias", "heavy"}, "--weighting"},
      {"evaluate frames --threads", {"-1", "2000"}, "--threads"},
      {"evaluate frames --seed", {"-1", "x", "18446744073709551616"}, "--seed"},
      {"evaluate frames --budget", {"30"}, "--budget"},
      {"select --target-translation-sigma", {"-1", "inf", "nan"}, "0 (none) or a positive finite number for --target-"},
      {"select --target-rotation-sigma",
       {"-1", "inf", "nan"},
       "0 (none) or a positive finite number for --target-translation-sigma and --target-rotation-sigma"}};
  for (const auto& [option, values, message] : refusals) {
    for (const std::string& value : values) expect_refused(run(option + " " + value), message);
  }
  EXPECT_EQ(run("select --repeat 1 --strategy stochastic_greedy --seed 18446744073709551615").exit_code, 0);
}

// Of every option that takes a value, as --help lists them.
TEST_F(Program, refuses_empty_values_of_all_options) {
  std::size_t options = 0;
  for (const char* const command : {"select", "evaluate"}) {
    std::istringstream help(run(std::string(command) + " --help").out);
    for (std::string line; std::getline(help, line);) {
      std::istringstream words(line);
      std::string option, value;
      words >> option >> value;
      if (option.rfind("--", 0) != 0 || value.size() < 3 || value != upper_case(value)) continue;
      ++options;
      for (const char* const given : {" ''", "=", "=''"}) {
        expect_refused(run(std::string(command) + " " + option + given), option);
      }
    }
  }
  EXPECT_GT(options, 15U);
}

TEST_F(Program, refuses_options_without_effect) {
  write_frame("frame_001.csv", 20);
  const struct {
    std::string option, value, needed, its_value;
  } idle[] = {
      {"--max-per-cell", " 2", "--grid", " 4x3"},
      {"--epsilon", " 0.2", "--strategy stochastic_greedy", ""},
      {"--seed", " 3", "--strategy stochastic_greedy", ""},
      {"--map-sigma", " 0.1", "--weighting measurement_and_map", ""},
  };
  for (const auto& [option, value, needed, its_value] : idle) {
    const std::string select = "select --input frames --repeat 1 " + option + value;
    expect_refused(run(select), option + " does nothing here; expected with it " + needed);
    EXPECT_EQ(run(select + " " + needed + its_value).exit_code, 0) << option;
  }
}

// A file is either complete or unchanged.
TEST_F(Program, leaves_no_partial_file) {
  const std::string select = "select --budget 100 --repeat 1 --json --plot-data ";
  std::ofstream(path("old.json")) << "old data\n";
  // In blocks of 512 bytes, in some shells 1024; the data of 2000 matches has 150 KB.
  const auto limited = [&](const std::string& file) {
    return run_script("ulimit -f 100\n" MAXLOGDET_PROGRAM " " + select + file + " >out.txt 2>err.txt </dev/null");
  };
  expect_refused(limited("new.json"), "new.json: cannot be written (File too large)");
  EXPECT_FALSE(std::filesystem::exists(path("new.json")));
  expect_refused(limited("old.json"), "old.json: cannot be written (File too large)");
  EXPECT_EQ(text_of(path("old.json")), "old data\n");

  std::filesystem::create_symlink("/dev/full", path("full.json"));
  expect_refused(run(select + "full.json"), "full.json: cannot be written (No space left on device)");
  EXPECT_TRUE(std::filesystem::is_symlink(path("full.json")));
  expect_refused(run(select + std::string(300, 'a') + ".json"), "a.json: cannot be written");

  std::filesystem::create_symlink("old.json", path("link.json"));
  EXPECT_EQ(run(select + "link.json").exit_code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(path("link.json")));
  EXPECT_EQ(nlohmann::json::parse(text_of(path("old.json"))).at("selected").size(), 100U);
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    EXPECT_NE(entry.path().extension(), ".new") << entry.path();
  }
}

TEST_F(Program, reports_that_standard_output_cannot_be_written) {
  for (const char* const command : {"select --repeat 1", "select --repeat 1 --json", "--help", "--version"}) {
    const Outcome outcome =
        run_script(MAXLOGDET_PROGRAM " " + std::string(command) + " >/dev/full 2>err.txt </dev/null");
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_EQ(outcome.err, "maxlogdet: standard output could not be written\n") << command;
  }
}

TEST_F(Program, refuses_or_warns_of_stereo_without_stereo_and_of_columns_that_may_be_misspelt) {
  write_frame("frame_001.csv", 20);
  const std::string good = text_of(path("frames/frame_001.csv"));
  const auto with = [&](const std::string& old, std::size_t length, const std::string& text) {
    std::ofstream(path("frames/frame_001.csv")) << std::string(good).replace(good.find(old), length, text);
  };
  with("50.45", good.find('\n') - good.find("50.45"), "0");  // the camera has no baseline
  EXPECT_EQ(run("select --input frames").exit_code, 0);
  expect_refused(run("select --input frames --stereo"), "bf > 0");
  with("u_right", 7, "uR");
  const Outcome outcome = run("select --input frames --stereo");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("unknown column 'uR'"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("no match has a right-image column"), std::string::npos) << outcome.err;
}

TEST_F(Program, counts_candidates_without_a_block) {
  write_frame("frame_001.csv", 20);
  const std::string camera = "# fx,fy,cx,cy,bf: 400,400,376,240,0\n# image width,height: 752,480\n# Tcw_prior: ";
  const std::string header = "\nmp_id,X,Y,Z,u,v\n";
  std::ofstream(path("frames/frame_002.csv"))
      << camera << "1,0,0,0,0,1,0,0,0,0,1,0" << header << "1,5,1,-3,296,240\n2,5,0,-1,376,160\n";  // behind it
  const auto objects = run_json("select --input frames --budget 10");
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].at("indices").size(), 10U);
  EXPECT_EQ(objects[1].at("status"), "all_selected");
  EXPECT_EQ(objects[1].at("invalid_candidates"), 2);
  EXPECT_EQ(objects[1].at("indices").size(), 0U);
  std::ofstream(path("ray.csv")) << camera << "0,-1,0,0,0,0,-1,0,1,0,0,0" << header
                                 << "1,5,1,0,296,240\n2,5,0,1,376,160\n";
  const Outcome outcome = run("select --input ray.csv --json --weighting map_bias_world");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("1 matches have no world-frame block"), std::string::npos) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("invalid_candidates"), 1);
}

TEST_F(Program, draws_selected_matches_red_in_both_views) {
  EXPECT_EQ(run("select --budget 100 --repeat 1 --plot-data \"it's.json\"").exit_code, 0);
  EXPECT_EQ(draw("\"it's.json\"").out, "drew it's.svg and .png\n");
  const std::string svg = text_of(path("it's.svg"));
  for (const char* const text : {"<svg", "map view", "camera view", "selected"}) {
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  }
  // gnuplot marks each point by <use xlink:href=... color='rgb(...)'/>, and once more in the legend of each view.
  const auto count = [&](const std::string& colour) {
    std::size_t marks = 0;
    std::istringstream lines(svg);
    for (std::string line; std::getline(lines, line);) {
      if (line.find("<use") != std::string::npos && line.find("color='" + colour + "'") != std::string::npos) ++marks;
    }
    return marks;
  };
  EXPECT_EQ(count("rgb(214,  32,  32)"), 2U * (100 + 1)) << "every selected match is inside the axes";
  EXPECT_GT(count("rgb( 52, 101, 196)"), 3500U);
  EXPECT_LE(count("rgb( 52, 101, 196)"), 2U * (1900 + 1));
}

TEST_F(Program, draws_a_picture_of_each_frame) {
  for (const char* const name : {"frame_001.csv", "frame_002.csv"}) write_frame(name, 50);
  const Outcome outcome = run("select --input frames --repeat 1 --budget 0 --plot-data picture.json");
  EXPECT_EQ(outcome.exit_code, 0);
  const std::string files = "data of a picture: picture_frame_001.json\ndata of a picture: picture_frame_002.json\n";
  EXPECT_NE(outcome.out.find("\n\n" + files), std::string::npos) << outcome.out;
  EXPECT_EQ(draw("picture_frame_001.json picture_frame_002.json").exit_code, 0);
  for (const char* const name : {"/picture_frame_001.png", "/picture_frame_002.png"}) {
    EXPECT_EQ(text_of(folder_ + name).substr(1, 3), "PNG");
  }
  expect_refused(run("select --repeat 1 --plot-data nowhere/picture.json"), "nowhere/picture.json: cannot be written");
}

TEST_F(Program, version_names_instruction_sets_and_threads) {
  const Outcome outcome = run("--version");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out.rfind("maxlogdet " + std::string(version()) + "\n", 0), 0U);
  for (const std::string& isa : sim::built_in_isas()) EXPECT_NE(outcome.out.find(" " + isa), std::string::npos) << isa;
  EXPECT_NE(outcome.out.find("active:                     " + std::string(active_isa())), std::string::npos);
  EXPECT_NE(outcome.out.find("threads"), std::string::npos);
  EXPECT_EQ(run("--help").exit_code, 0);
}

}  // namespace
}  // namespace maxlogdet::test
