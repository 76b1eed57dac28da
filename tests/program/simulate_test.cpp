// SPDX-License-Identifier: MIT
#include "tests/program/simulate.hpp"

#include <set>

namespace maxlogdet::test {
namespace {

TEST_F(Simulate, metrics_writes_tables_runs_and_data_of_pictures) {
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
  EXPECT_EQ(json.at("runs_finished"), 4);
  EXPECT_EQ(json.at("table").size(), rows.size() - 1);
  EXPECT_EQ(json.at("table")[0].at("rms_translation_m").get<double>(), std::stod(rows.at(1).at(4)));
  EXPECT_EQ(contents("out/metrics.md") + "tables and every run: out/metrics*\n", outcome.out);
  EXPECT_EQ(draw("out").exit_code, 0);
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

TEST_F(Simulate, resumes_where_it_stopped) {
  ASSERT_EQ(run(small_metrics).exit_code, 0);
  const std::string complete = contents("out/metrics.csv");
  std::string log = contents("out/metrics_runs.jsonl");
  const std::size_t second_run = log.find('\n', log.find('\n') + 1) + 1;
  std::ofstream(path("out/metrics_runs.jsonl")) << log.substr(0, second_run + 100);  // interrupted in the second run
  std::filesystem::remove(path("out/metrics.csv"));
  ASSERT_EQ(run(small_metrics).exit_code, 0);
  EXPECT_EQ(contents("out/metrics.csv"), complete);
  const std::string first_run = log.substr(0, second_run);
  EXPECT_EQ(contents("out/metrics_runs.jsonl").rfind(first_run, 0), 0U) << "the first run is not repeated";

  const Outcome other = run(std::string(small_metrics) + " --map-bias 0.1");
  expect_refused(other, "out/metrics_runs.jsonl:1: holds runs of other settings");
}

TEST_F(Simulate, refuses_a_damaged_file_of_runs) {
  ASSERT_EQ(run(small_metrics).exit_code, 0);
  const std::string log = contents("out/metrics_runs.jsonl");
  const std::string settings = log.substr(0, log.find('\n') + 1);
  for (const char* const result : {"[]", "[[1,2]]", "{}", "7", R"(["x"])"}) {
    std::ofstream(path("out/metrics_runs.jsonl")) << settings << R"({"key":"1","result":)" << result << "}\n";
    expect_refused(run(small_metrics), "out/metrics_runs.jsonl: run 1 is damaged");
  }
  std::ofstream(path("out/metrics_runs.jsonl")) << "something else\n";
  expect_refused(run(small_metrics), "not written by this program");
}

TEST_F(Simulate, ctrl_c_keeps_finished_runs) {
  // A million runs take hours; the first two take less than 600 tenths of a second.
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
  EXPECT_GE(json.at("runs_finished"), 2);
  EXPECT_EQ(json.at("table")[0].at("runs"), json.at("runs_finished"));
}

TEST_F(Simulate, epsilon_covers_its_grid) {
  ASSERT_EQ(run("simulate epsilon --sizes 60,100 --runs 2 --output out").exit_code, 0);
  EXPECT_EQ(csv("out/epsilon.csv").size(), 1 + 2 * 2 * 8 * 8U);
  EXPECT_EQ(draw("out").exit_code, 0);
  for (const char* const map : {"time", "gap", "differing"}) {
    EXPECT_NE(contents(std::string("out/epsilon_") + map + ".svg").find("n = 100"), std::string::npos);
  }
  ASSERT_EQ(run("simulate epsilon --sizes 60,100 --runs 2 --threads 2 --output two").exit_code, 0);
  EXPECT_EQ(without_times("out/epsilon.csv"), without_times("two/epsilon.csv"));
}

constexpr char small_robustness[] = "simulate robustness --matches 60 --budgets 15,30 --runs 3 --output out";

TEST_F(Simulate, robustness_covers_its_cases_for_any_number_of_threads) {
  const Outcome outcome = run(std::string(small_robustness) + " --threads 1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(csv("out/robustness.csv").size(), 1 + 10 * (9 * 2 + 1U));
  EXPECT_EQ(contents("out/robustness.md") + "tables and every run: out/robustness*\n", outcome.out);
  EXPECT_EQ(draw("out").exit_code, 0);
  const auto json = nlohmann::json::parse(contents("out/robustness.json"));
  EXPECT_EQ(json.at("runs_finished"), 3);
  EXPECT_EQ(json.at("table")[0].at("disturbance"), "none");
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

// Of options that are given bad values the error names the option.
TEST_F(Simulate, refuses_invalid_values) {
  const std::vector<const char*> no_numbers = {"nan", "inf", "-11", "x", "1e99"};
  const std::pair<std::string, std::vector<const char*>> bad[] = {{"metrics --runs", {"0"}},
                                                                  {"metrics --threads", {"-1"}},
                                                                  {"metrics --seed", {"x"}},
                                                                  {"metrics --sizes", {"4", "400", "ten"}},
                                                                  {"metrics --noise", {"0", "nan"}},
                                                                  {"metrics --points", {"5"}},
                                                                  {"metrics --weightings", {"heavy"}},
                                                                  {"metrics --prior", {"0", "1e-21"}},
                                                                  {"metrics --nearest", {"30"}},
                                                                  {"metrics --map-bias", {"inf"}},
                                                                  {"epsilon --sizes", {"5"}},
                                                                  {"epsilon --epsilons", {"2"}},
                                                                  {"euroc --budget", {"1"}},
                                                                  {"euroc --outliers", {"0.9"}},
                                                                  {"robustness --matches", {"10", "-1"}},
                                                                  {"robustness --budgets", {"5", "1000", "x"}},
                                                                  {"robustness --keyframes", {"0"}},
                                                                  {"robustness --disturbances", {"fog"}},
                                                                  {"robustness --scene", {"far_narrow"}},
                                                                  {"robustness --runs", {"0"}},
                                                                  {"robustness --seed", {"x"}}};
  for (const auto& [option, values] : bad) {
    for (const char* const value : values) {
      expect_refused(run("simulate " + option + " " + value), option.substr(option.find("--")));
    }
  }
  for (const char* const option :
       {"euroc --pixel-sigma", "euroc --outliers", "euroc --batch-translation", "euroc --map-sigma", "euroc --seconds",
        "robustness --pixel-sigma", "robustness --map-sigma", "robustness --batch-translation",
        "robustness --batch-rotation", "robustness --patch-sigma", "robustness --gate", "robustness --focal-error",
        "robustness --tau"}) {
    for (const char* const value : no_numbers) {
      const std::string given = option;
      expect_refused(run("simulate " + given + " " + value), given.substr(given.find("--")));
    }
  }
}

TEST_F(Simulate, refuses_invalid_arguments) {
  write_trajectory("a,b");
  std::ofstream(path("file")) << "no folder\n";
  const std::pair<const char*, const char*> refusals[] = {
      {"", "an experiment is missing: metrics, budget, euroc, epsilon or robustness"},
      {" everything", "everything"},
      {" metrics --prior 0", "--prior: expected a number from 1e-20 to 1e6"},
      {" metrics --map-bias inf", "--map-bias: expected -1 to 1 m"},
      {" metrics --nearest 0.6 --farthest 0.9 --map-bias -1", "in front of the camera"},
      {" metrics --output file/out", "file/out"},
      {" euroc --trajectories nowhere", "nowhere"},
      {" euroc --trajectories frames", "frames"},
      {" euroc --trajectories tum", "a,b.txt: expected a file name of letters"},
      {" euroc --budget 300", "--pool 200; expected at least the budget, 300"}};
  for (const auto& [arguments, message] : refusals) {
    expect_refused(run("simulate" + std::string(arguments)), message);
  }
  EXPECT_EQ(run(std::string(small_metrics) + " --prior 1e-20").exit_code, 0) << "the smallest that the library takes";
  expect_refused(run("simulate metrics", "MAXLOGDET_ISA=avx1024 "), "MAXLOGDET_ISA is 'avx1024'; expected one that");
}

TEST_F(Simulate, needs_no_gnuplot) {
  EXPECT_EQ(run(small_metrics, "PATH=nowhere ").exit_code, 0);
  EXPECT_EQ(csv("out/metrics.csv").size(), 1 + 2 * 2 * 3 * 7U);
}

}  // namespace
}  // namespace maxlogdet::test
