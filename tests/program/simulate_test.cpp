// SPDX-License-Identifier: MIT
#include "tests/program/simulate.hpp"

#include <set>

namespace maxlogdet::test {
namespace {

TEST_F(Simulate, metrics_writes_tables_and_data_of_pictures) {
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
  const auto json = nlohmann::json::parse(contents("out/metrics.json"));
  EXPECT_EQ(json.at("table").size(), rows.size() - 1);
  EXPECT_EQ(json.at("table")[0].at("rms_translation_m").get<double>(), std::stod(rows.at(1).at(4)));
  EXPECT_EQ(contents("out/metrics.md") + "tables: out/metrics*\n", outcome.out);
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
  for (const char* const file : {"metrics.csv", "metrics_aligned.csv", "metrics.json"}) {
    EXPECT_EQ(contents(std::string("out1/") + file), contents(std::string("out2/") + file)) << file;
    EXPECT_NE(contents(std::string("out1/") + file), contents(std::string("out3/") + file)) << file;
  }
}

TEST_F(Simulate, epsilon_covers_its_grid) {
  ASSERT_EQ(run("epsilon --sizes 60,100 --runs 2 --output out").exit_code, 0);
  EXPECT_EQ(csv("out/epsilon.csv").size(), 1 + 2 * 2 * 8 * 8U);
  EXPECT_EQ(draw("out").exit_code, 0);
  for (const char* const map : {"time", "gap", "differing"}) {
    EXPECT_NE(contents(std::string("out/epsilon_") + map + ".svg").find("n = 100"), std::string::npos);
  }
  ASSERT_EQ(run("epsilon --sizes 60,100 --runs 2 --threads 2 --output two").exit_code, 0);
  EXPECT_EQ(without_times("out/epsilon.csv"), without_times("two/epsilon.csv"));
}

// Of options that are given bad values the error names the option.
TEST_F(Simulate, refuses_invalid_values) {
  const std::vector<const char*> no_numbers = {"nan", "inf", "-11", "x", "1e99"};
  const std::pair<std::string, std::vector<const char*>> bad[] = {
      {"metrics --runs", {"0"}},           {"metrics --threads", {"-1"}},
      {"metrics --seed", {"x"}},           {"metrics --sizes", {"4", "400", "ten"}},
      {"metrics --noise", {"0", "nan"}},   {"metrics --points", {"5"}},
      {"metrics --weightings", {"heavy"}}, {"metrics --prior", {"0", "1e-21"}},
      {"metrics --nearest", {"30"}},       {"metrics --map-bias", {"inf"}},
      {"epsilon --sizes", {"5"}},          {"epsilon --epsilons", {"2"}},
      {"euroc --budget", {"1"}},           {"euroc --pixel-sigma", no_numbers},
      {"euroc --outliers", no_numbers},    {"euroc --batch-translation", no_numbers},
      {"euroc --map-sigma", no_numbers},   {"euroc --seconds", no_numbers}};
  for (const auto& [option, values] : bad) {
    for (const char* const value : values) expect_refused(run(option + " " + value), option.substr(option.find("--")));
  }
}

TEST_F(Simulate, refuses_invalid_arguments) {
  write_trajectory("a,b");
  std::ofstream(path("file")) << "no folder\n";
  const std::pair<const char*, const char*> refusals[] = {
      {"", "a command is missing: metrics, budget, euroc, epsilon"},
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
    expect_refused(run(arguments), message);
  }
  EXPECT_EQ(run(std::string(small_metrics) + " --prior 1e-20").exit_code, 0) << "the smallest that the library takes";
  expect_refused(run("metrics", "MAXLOGDET_ISA=avx1024 "), "MAXLOGDET_ISA is 'avx1024'; expected one that");
}

}  // namespace
}  // namespace maxlogdet::test
