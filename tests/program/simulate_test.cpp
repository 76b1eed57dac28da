// SPDX-License-Identifier: MIT
#include "sim/trajectory.hpp"
#include "tests/support/program.hpp"

#include <map>
#include <set>

namespace maxlogdet::test {
namespace {

// Small enough for an emulator.
constexpr char small_metrics[] = "simulate metrics --points 40 --sizes 15,30 --runs 4 --output out";

class Simulate : public Program {
 protected:
  std::string contents(const std::string& file) const { return contents_of(folder_ + "/" + file); }

  // The cells of a CSV file, the header first.
  std::vector<std::vector<std::string>> csv(const std::string& file) const {
    std::istringstream lines(contents(file));
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream cells(line);
      rows.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
  }

  // The rows without columns whose names begin with ms_ or us: what a clock says.
  std::vector<std::vector<std::string>> without_times(const std::string& file) const {
    auto rows = csv(file);
    const std::vector<std::string> header = rows.at(0);
    for (auto& row : rows) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (header[i].rfind("ms_", 0) == 0 || header[i].rfind("us", 0) == 0) row[i].clear();
      }
    }
    return rows;
  }

  void write_trajectory(const std::string& name) const {
    std::filesystem::create_directories(folder_ + "/tum");
    sim::Trajectory trajectory = sim::analytic_trajectory(5, 10);
    write_tum(trajectory, folder_ + "/tum/" + name + ".txt");
  }
  std::string small_tracking(const std::string& experiment) const {
    return "simulate " + experiment + " --trajectories tum --max-matches 150 --runs 2 ";
  }
};

TEST_F(Simulate, metrics_writes_tables_every_run_and_what_pictures_need) {
  const Outcome outcome = run(small_metrics);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_NE(outcome.out.find("max_log_det"), std::string::npos);
  const auto rows = csv("out/metrics.csv");
  EXPECT_EQ(sim::joined(rows.at(0), ","),
            "noise_px,size,weighting,selector,rms_translation_m,rms_rotation_deg,ci95_translation_m,ci95_rotation_deg,"
            "runs");
  std::set<std::string> selectors, weightings;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    weightings.insert(rows[i].at(2));
    selectors.insert(rows[i].at(3));
    EXPECT_EQ(rows[i].at(8), "4");
    EXPECT_GT(std::stod(rows[i].at(4)), 0);
  }
  EXPECT_EQ(weightings, (std::set<std::string>{"map_bias", "measurement", "measurement_and_map"}));
  EXPECT_EQ(selectors, (std::set<std::string>{"max_log_det", "max_trace", "min_condition", "max_min_eigenvalue",
                                              "random", "all", "all_weighted"}));
  EXPECT_EQ(rows.size(), 1 + 2 * 2 * 3 * 7U);
  EXPECT_EQ(csv("out/metrics_aligned.csv").at(0), rows.at(0));
  EXPECT_EQ(csv("out/metrics_runs.csv").size(), 1 + 4 * 2 * (2 * (3 * 4 + 1) + 2U));
  const auto json = nlohmann::json::parse(contents("out/metrics.json"));
  EXPECT_EQ(json["runs_finished"], 4);
  EXPECT_EQ(json["table"].size(), rows.size() - 1);
  EXPECT_EQ(json["table"][0]["rms_translation_m"].get<double>(), std::stod(rows.at(1).at(4)));
  EXPECT_EQ(contents("out/metrics.md") + "tables and every run: out/metrics*\n", outcome.out);
  EXPECT_EQ(draw("experiment", "out").exit_code, 0);
  for (const char* const picture : {"map_bias", "measurement", "measurement_and_map", "scene"}) {
    const std::string name = std::string("out/metrics_") + picture;
    EXPECT_NE(contents(name + ".svg").find("<svg"), std::string::npos) << picture;
    EXPECT_EQ(contents(name + ".png").substr(1, 3), "PNG") << picture;
  }
}

TEST_F(Simulate, results_do_not_depend_on_threads_and_do_on_the_seed) {
  ASSERT_EQ(run(std::string(small_metrics) + "1 --threads 1").exit_code, 0);
  ASSERT_EQ(run(std::string(small_metrics) + "2 --threads 2").exit_code, 0);
  ASSERT_EQ(run(std::string(small_metrics) + "3 --seed 1").exit_code, 0);
  for (const char* const file : {"metrics.csv", "metrics_aligned.csv", "metrics_runs.csv", "metrics.json"}) {
    EXPECT_EQ(contents(std::string("out1/") + file), contents(std::string("out2/") + file)) << file;
    EXPECT_NE(contents(std::string("out1/") + file), contents(std::string("out3/") + file)) << file;
  }
}

TEST_F(Simulate, goes_on_where_it_stopped) {
  ASSERT_EQ(run(small_metrics).exit_code, 0);
  const std::string whole = contents("out/metrics.csv");
  std::string log = contents("out/metrics_runs.jsonl");
  const std::size_t second_run = log.find('\n', log.find('\n') + 1) + 1;
  std::ofstream(folder_ + "/out/metrics_runs.jsonl") << log.substr(0, second_run + 100);  // killed in its second run
  std::filesystem::remove(folder_ + "/out/metrics.csv");
  ASSERT_EQ(run(small_metrics).exit_code, 0);
  EXPECT_EQ(contents("out/metrics.csv"), whole);
  const std::string first_run = log.substr(0, second_run);
  EXPECT_EQ(contents("out/metrics_runs.jsonl").rfind(first_run, 0), 0U) << "the first run is not made anew";

  const Outcome other = run(std::string(small_metrics) + " --map-bias 0.1");
  expect_refused(other, "out/metrics_runs.jsonl:1: holds runs of other settings");
}

TEST_F(Simulate, refuses_a_damaged_file_of_runs) {
  ASSERT_EQ(run(small_metrics).exit_code, 0);
  const std::string log = contents("out/metrics_runs.jsonl");
  const std::string settings = log.substr(0, log.find('\n') + 1);
  for (const char* const result : {"[]", "[[1,2]]", "{}", "7", R"(["x"])"}) {
    std::ofstream(folder_ + "/out/metrics_runs.jsonl") << settings << R"({"key":"1","result":)" << result << "}\n";
    expect_refused(run(small_metrics), "out/metrics_runs.jsonl: run 1 is damaged");
  }
  std::ofstream(folder_ + "/out/metrics_runs.jsonl") << "something else\n";
  expect_refused(run(small_metrics), "not written by this program");
}

TEST_F(Simulate, ctrl_c_leaves_what_is_finished) {
  // A million runs take hours; 600 tenths of a second are patience enough for the first two.
  const Outcome outcome = run_script(MAXLOGDET_PROGRAM
                                     " simulate metrics --points 40 --sizes 15 --runs 1000000 --output out "
                                     ">out.txt 2>err.txt </dev/null &\n"
                                     "pid=$!\n"
                                     "for i in $(seq 600); do\n"
                                     "  [ $(cat out/metrics_runs.jsonl 2>/dev/null | wc -l) -ge 3 ] && break\n"
                                     "  sleep 0.1\n"
                                     "done\n"
                                     "kill -INT $pid; wait $pid");
  EXPECT_EQ(outcome.exit_code, 130);
  EXPECT_NE(outcome.err.find("of 1000000 runs are finished"), std::string::npos) << outcome.err;
  const auto json = nlohmann::json::parse(contents("out/metrics.json"));
  EXPECT_GE(json["runs_finished"], 2);
  EXPECT_EQ(json["table"][0]["runs"], json["runs_finished"]);
}

TEST_F(Simulate, euroc_tracks_along_given_trajectories) {
  write_trajectory("first");
  write_trajectory("second");
  const Outcome outcome = run(small_tracking("euroc") + "--threads 1 --output one");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto rows = csv("one/euroc.csv");
  EXPECT_EQ(sim::joined(rows.at(0), ","),
            "sequence,selector,run,ate_m,rpe_m_per_s,roe_deg_per_s,ms_outliers,ms_selection,ms_pose");
  std::map<std::string, int> runs_of;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    ++runs_of[rows[i].at(1)];
    EXPECT_LT(std::stod(rows[i].at(3)), 1) << "m: it keeps track";
    EXPECT_GT(std::stod(rows[i].at(8)), 0);
  }
  for (const char* const selector :
       {"quality", "bucket", "observability", "md", "quality_md", "inl", "all", "all_weighted", "random"}) {
    EXPECT_EQ(runs_of[selector], 4) << selector;
    EXPECT_NE(outcome.out.find(selector), std::string::npos);
  }
  EXPECT_EQ(rows.size(), 1 + 9 * 4U);
  EXPECT_EQ(draw("experiment", "one").exit_code, 0);
  EXPECT_NE(contents("one/euroc.svg").find("<svg"), std::string::npos);
  EXPECT_EQ(contents("one/euroc.png").substr(1, 3), "PNG");
  EXPECT_EQ(nlohmann::json::parse(contents("one/euroc.json"))["table"].size(), 36U);

  ASSERT_EQ(run(small_tracking("euroc") + "--threads 2 --output two").exit_code, 0);
  EXPECT_EQ(without_times("one/euroc.csv"), without_times("two/euroc.csv"));
}

TEST_F(Simulate, euroc_takes_sequences_and_selectors_by_name) {
  write_trajectory("first");
  write_trajectory("second");
  ASSERT_EQ(run(small_tracking("euroc") + "--sequences second --selectors md,all --seconds 3.5 --output out").exit_code,
            0);
  const auto rows = csv("out/euroc.csv");
  ASSERT_EQ(rows.size(), 1 + 2 * 2U);
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_EQ(rows[i].at(0), "second");
  expect_refused(run(small_tracking("euroc") + "--sequences third"), "'third'; expected one of first, second");
  expect_refused(run(small_tracking("euroc") + "--selectors best"), "best");
}

TEST_F(Simulate, residuals_are_whitened_as_told) {
  write_trajectory("first");
  const std::string euroc = small_tracking("euroc") + "--seconds 3.5 --selectors md,all,all_weighted ";
  ASSERT_EQ(run(euroc + "--output plain").exit_code, 0);
  ASSERT_EQ(run(euroc + "--weights measurement --output told").exit_code, 0);
  const Outcome outcome = run(euroc + "--weights measurement_and_map --output map");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(without_times("told/euroc.csv"), without_times("plain/euroc.csv")) << "the default";
  const auto plain = csv("plain/euroc.csv"), map = csv("map/euroc.csv");
  ASSERT_EQ(map.size(), 1 + 3 * 2U);
  std::map<std::string, std::vector<std::string>> errors_of;
  for (std::size_t i = 1; i < map.size(); ++i) {
    const std::string& selector = map[i].at(1);
    errors_of[selector].push_back(map[i].at(3));
    EXPECT_EQ(map[i].at(3) == plain.at(i).at(3), selector == "all_weighted") << selector;
  }
  EXPECT_EQ(errors_of["all"], errors_of["all_weighted"]) << "nothing is left to tell them apart";

  EXPECT_EQ(nlohmann::json::parse(contents("plain/euroc.json"))["settings"]["weights"], "measurement");
  EXPECT_EQ(nlohmann::json::parse(contents("map/euroc.json"))["settings"]["weights"], "measurement_and_map");
  EXPECT_NE(contents("plain/euroc.md").find("whitened by measurement noise (all_weighted: and"), std::string::npos);
  EXPECT_NE(contents("map/euroc.md").find("whitened by measurement noise and errors of the map"), std::string::npos);
  expect_refused(run(euroc + "--output map"), "map/euroc_runs.jsonl:1: holds runs of other settings");

  const std::string budget = small_tracking("budget") + "--seconds 3.5 --budgets 40 --output ";
  ASSERT_EQ(run(budget + "budget").exit_code, 0);
  ASSERT_EQ(run(budget + "budget_map --weights measurement_and_map").exit_code, 0);
  const auto rows = csv("budget/budget.csv"), rows_of_map = csv("budget_map/budget.csv");
  ASSERT_EQ(rows_of_map.size(), 1 + 3 * 2U);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at(4) == rows_of_map.at(i).at(4), rows[i].at(1) == "all_weighted") << rows[i].at(1);
  }
  EXPECT_NE(contents("budget_map/budget.md").find("and errors of the map"), std::string::npos);
}

TEST_F(Simulate, without_recorded_trajectories_one_is_built_in) {
  const Outcome outcome =
      run("simulate budget --budgets 20 --runs 1 --seconds 4 --max-matches 60 --output out", "MAXLOGDET_DATA=nowhere ");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("the built-in one is used"), std::string::npos);
  EXPECT_EQ(csv("out/budget.csv").size(), 4U);
}

TEST_F(Simulate, budget_compares_budgets_with_all_inliers) {
  write_trajectory("first");
  ASSERT_EQ(run(small_tracking("budget") + "--budgets 20,60 --output out").exit_code, 0);
  const auto rows = csv("out/budget.csv");
  EXPECT_EQ(sim::joined(rows.at(0), ","), "sequence,selector,budget,run,ate_m,rpe_m_per_s,roe_deg_per_s");
  ASSERT_EQ(rows.size(), 1 + 4 * 2U);
  std::set<std::pair<std::string, std::string>> contestants;
  for (std::size_t i = 1; i < rows.size(); ++i) contestants.insert({rows[i].at(1), rows[i].at(2)});
  EXPECT_EQ(contestants, (std::set<std::pair<std::string, std::string>>{
                             {"md", "20"}, {"md", "60"}, {"inl", "0"}, {"all_weighted", "0"}}));
  EXPECT_EQ(draw("experiment", "out").exit_code, 0);
  EXPECT_NE(contents("out/budget.svg").find("inl, median"), std::string::npos);
  EXPECT_NE(contents("out/budget.svg").find("all weighted, median"), std::string::npos);
}

TEST_F(Simulate, epsilon_covers_its_grid) {
  ASSERT_EQ(run("simulate epsilon --sizes 60,100 --runs 2 --output out").exit_code, 0);
  EXPECT_EQ(csv("out/epsilon.csv").size(), 1 + 2 * 2 * 8 * 8U);
  EXPECT_EQ(draw("experiment", "out").exit_code, 0);
  for (const char* const map : {"time", "gap", "differing"}) {
    EXPECT_NE(contents(std::string("out/epsilon_") + map + ".svg").find("n = 100"), std::string::npos);
  }
  ASSERT_EQ(run("simulate epsilon --sizes 60,100 --runs 2 --threads 2 --output two").exit_code, 0);
  EXPECT_EQ(without_times("out/epsilon.csv"), without_times("two/epsilon.csv"));
}

constexpr char small_robustness[] = "simulate robustness --matches 60 --budgets 15,30 --runs 3 --output out";

TEST_F(Simulate, robustness_covers_its_cases_whatever_the_threads) {
  const Outcome outcome = run(std::string(small_robustness) + " --threads 1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(csv("out/robustness.csv").size(), 1 + 10 * (9 * 2 + 1U));
  EXPECT_EQ(contents("out/robustness.md") + "tables and every run: out/robustness*\n", outcome.out);
  EXPECT_EQ(draw("experiment", "out").exit_code, 0);
  const auto json = nlohmann::json::parse(contents("out/robustness.json"));
  EXPECT_EQ(json["runs_finished"], 3);
  EXPECT_EQ(json["table"][0]["disturbance"], "none");
  for (const char* const picture : {"out/robustness_translation", "out/robustness_rotation"}) {
    EXPECT_NE(contents(std::string(picture) + ".svg").find("sigma_uneven"), std::string::npos) << picture;
    EXPECT_EQ(contents(std::string(picture) + ".png").substr(1, 3), "PNG") << picture;
  }
  ASSERT_EQ(run(std::string(small_robustness) + "2 --threads 2").exit_code, 0);
  EXPECT_EQ(contents("out/robustness.csv"), contents("out2/robustness.csv"));
  expect_refused(run(std::string(small_robustness) + " --tau 1"), "holds runs of other settings");
  ASSERT_EQ(
      run("simulate robustness --matches 60 --budgets 30 --runs 1 --disturbances focal,none --output one").exit_code,
      0);
  EXPECT_EQ(csv("one/robustness.csv").size(), 1 + 2 * 10U);
}

TEST_F(Simulate, robustness_refuses_arguments_that_make_no_sense) {
  const std::string robustness = "simulate robustness --";
  for (const char* const bad : {"matches 10", "matches -1", "budgets 5", "budgets 1000", "budgets x", "keyframes 0",
                                "disturbances fog", "scene far_narrow", "runs 0", "seed x"}) {
    const std::string option = bad;
    expect_refused(run(robustness + option), "--" + option.substr(0, option.find(' ')));
  }
  for (const char* const option : {"pixel-sigma", "map-sigma", "batch-translation", "batch-rotation", "patch-sigma",
                                   "gate", "focal-error", "tau"}) {
    for (const char* const value : {"nan", "inf", "-11", "x", "1e99"}) {
      expect_refused(run(robustness + option + " " + value), std::string("--") + option);
    }
  }
}

TEST_F(Simulate, refuses_arguments_that_make_no_sense) {
  expect_refused(run("simulate"), "an experiment is missing: metrics, budget, euroc, epsilon or robustness");
  expect_refused(run("simulate everything"), "everything");
  expect_refused(run("simulate metrics --runs 0"), "--runs");
  expect_refused(run("simulate metrics --threads -1"), "--threads");
  expect_refused(run("simulate metrics --seed x"), "--seed");
  expect_refused(run("simulate metrics --sizes 4"), "--sizes");
  expect_refused(run("simulate metrics --sizes 400"), "--sizes");
  expect_refused(run("simulate metrics --sizes ten"), "--sizes");
  expect_refused(run("simulate metrics --noise 0"), "--noise");
  expect_refused(run("simulate metrics --noise nan"), "--noise");
  expect_refused(run("simulate metrics --points 5"), "--points");
  expect_refused(run("simulate metrics --weightings heavy"), "heavy");
  expect_refused(run("simulate metrics --prior 0"), "--prior: expected a number from 1e-20 to 1e6");
  expect_refused(run("simulate metrics --prior 1e-21"), "--prior: expected a number from 1e-20 to 1e6");
  EXPECT_EQ(run(std::string(small_metrics) + " --prior 1e-20").exit_code, 0) << "the smallest that the library takes";
  expect_refused(run("simulate metrics --nearest 30"), "--nearest");
  expect_refused(run("simulate metrics --map-bias nan"), "--map-bias");
  std::ofstream(folder_ + "/file") << "no folder\n";
  expect_refused(run("simulate metrics --output file/out"), "file/out");
  expect_refused(run("simulate epsilon --sizes 5"), "--sizes");
  expect_refused(run("simulate epsilon --epsilons 2"), "--epsilons");
  expect_refused(run("simulate euroc --trajectories nowhere"), "nowhere");
  expect_refused(run("simulate euroc --trajectories frames"), "frames");
  expect_refused(run("simulate euroc --budget 1"), "--budget");
  for (const char* const option : {"pixel-sigma", "outliers", "batch-translation", "map-sigma", "seconds"}) {
    for (const char* const value : {"nan", "inf", "-1", "x", "1e99"}) {
      expect_refused(run(std::string("simulate euroc --") + option + " " + value), std::string("--") + option);
    }
  }
  write_trajectory("a,b");
  expect_refused(run("simulate euroc --trajectories tum"), "a,b.txt: expected a file name of letters");
  expect_refused(run("simulate metrics --nearest 0.6 --farthest 0.9 --map-bias -1"), "in front of the camera");
  expect_refused(run("simulate euroc --outliers 0.9"), "--outliers");
  expect_refused(run("simulate euroc --budget 300"), "--pool 200; expected at least the budget, 300");
  expect_refused(run("simulate metrics", "MAXLOGDET_ISA=avx1024 "), "MAXLOGDET_ISA is 'avx1024'; expected one that");
}

TEST_F(Simulate, refuses_options_that_do_nothing_without_another) {
  write_trajectory("first");
  const std::string euroc = small_tracking("euroc") + "--selectors ";
  expect_refused(run(euroc + "inl,all --budget 50"), "--budget does nothing here; expected with it a selector");
  expect_refused(run(euroc + "md,inl --pool 150"), "--pool does nothing here; expected with it --selectors quality_md");
  expect_refused(run(euroc + "random --strategy greedy"), "--strategy does nothing here");
  expect_refused(run(euroc + "random --weighting measurement"), "--weighting does nothing here");
  expect_refused(run(euroc + "md --map-sigma 0.1"), "--map-sigma does nothing here");
  expect_refused(run(euroc + "inl --weights measurement --map-sigma 0.1"), "--map-sigma does nothing here");
  expect_refused(run(euroc + "all_weighted --weights measurement_and_map"), "--weights does nothing here");
  expect_refused(run(euroc + "inl --weights map_bias"), "--weights");
  expect_refused(run(euroc + "leverage --strategy greedy"), "--strategy does nothing here");
  expect_refused(run(euroc + "md,shared_cells"), "expected --weighting measurement or measurement_and_map");
  const std::string used = " --seconds 0.3 --map-sigma 0.1 --budget 20 --output ";
  EXPECT_EQ(
      run(euroc + "quality_md --pool 30 --strategy greedy --weighting measurement_and_map" + used + "out").exit_code,
      0);
  EXPECT_EQ(run(euroc + "random,all_weighted" + used + "other").exit_code, 0);
  EXPECT_EQ(run(euroc + "random --weights measurement_and_map" + used + "weights").exit_code, 0);
  EXPECT_EQ(run(euroc +
                "leverage,half_random,md_cells,md_keyframes,shared_cells,shared_keyframes --weighting "
                "measurement_and_map" +
                used + "rest")
                .exit_code,
            0);
}

TEST_F(Simulate, says_that_a_file_cannot_be_written_and_leaves_no_half_of_it) {
  // In blocks of 512 bytes: enough for the runs, and not for their table.
  const Outcome outcome = run_script("ulimit -f 68\n" MAXLOGDET_PROGRAM " " + std::string(small_metrics) +
                                     " >out.txt 2>err.txt </dev/null");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("out/metrics_runs.csv: cannot be written (File too large)"), std::string::npos)
      << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/out/metrics_runs.csv"));
  EXPECT_EQ(csv("out/metrics.csv").size(), 1 + 2 * 2 * 3 * 7U) << "what was written before is complete";
  for (const auto& entry : std::filesystem::directory_iterator(folder_ + "/out")) {
    EXPECT_NE(entry.path().extension(), ".new") << entry.path();
  }
}

TEST_F(Simulate, without_gnuplot_there_are_numbers_and_drawing_says_why_there_are_no_pictures) {
  const Outcome outcome = run(small_metrics, "PATH=nowhere ");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_FALSE(contents("out/metrics.json").empty());
  EXPECT_EQ(csv("out/metrics.csv").size(), 1 + 2 * 2 * 3 * 7U);
  // One that fails stands in for none: the interpreter has to be found along the same path.
  std::filesystem::create_directories(folder_ + "/bin");
  std::ofstream(folder_ + "/bin/gnuplot") << "#!/bin/sh\necho 'no font' >&2\nexit 1\n";
  std::filesystem::permissions(folder_ + "/bin/gnuplot", std::filesystem::perms::owner_all);
  const Outcome failed = draw("experiment", "out", "PATH='" + folder_ + "'/bin:$PATH ");
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_EQ(failed.err, "out/metrics_map_bias.svg: gnuplot could not draw it: no font\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/out/metrics_map_bias.svg"));
}

TEST_F(Simulate, takes_subsets_of_all_points) {
  const Outcome outcome = run("simulate metrics --points 40 --sizes 40 --runs 3 --output out");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(csv("out/metrics.csv").size(), 1 + 2 * 3 * 7U);
}

TEST_F(Simulate, trajectories_too_short_for_a_window_have_no_relative_error_but_pictures) {
  write_trajectory("first");
  const Outcome outcome = run(small_tracking("euroc") + "--seconds 2 --output out");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string warning = "maxlogdet: first is 2 s long, shorter than a window of 3 s: it has no relative errors\n";
  EXPECT_EQ(outcome.err, warning);
  EXPECT_EQ(csv("out/euroc.csv").at(1).at(4), "nan");
  EXPECT_TRUE(nlohmann::json::parse(contents("out/euroc.json"))["table"][0]["rpe_m_per_s"].is_null());
  EXPECT_EQ(run(small_tracking("budget") + "--seconds 2 --budgets 20 --output out").err, warning);
  EXPECT_EQ(draw("experiment", "out").out, "drew out/budget.svg and .png\ndrew out/euroc.svg and .png\n");
  expect_refused(run(small_tracking("euroc") + "--seconds 0.1 --output short"), "at least 3 poses of first");
}

TEST_F(Simulate, trajectories_of_the_same_name_are_not_taken_for_each_other) {
  write_trajectory("first");
  ASSERT_EQ(run(small_tracking("euroc") + "--seconds 3.5 --selectors md --output out").exit_code, 0);
  std::string text = contents("tum/first.txt");
  text[text.find_last_of("0123456789", text.rfind('\n', text.size() / 10)) - 6] ^= 1;  // some digit of a quaternion
  std::ofstream(folder_ + "/tum/first.txt") << text;
  expect_refused(run(small_tracking("euroc") + "--seconds 3.5 --selectors md --output out"),
                 "holds runs of other settings");
}

TEST_F(Simulate, names_the_line_of_a_malformed_trajectory) {
  write_trajectory("first");
  std::ofstream(folder_ + "/tum/first.txt", std::ios::app) << "1e9 1 2 oops 0 0 0 1\n";
  const Outcome outcome = run("simulate euroc --trajectories tum --output out");
  expect_refused(outcome, "tum/first.txt:");
  EXPECT_NE(outcome.err.find("oops"), std::string::npos);
}

}  // namespace
}  // namespace maxlogdet::test
