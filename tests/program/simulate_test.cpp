// SPDX-License-Identifier: MIT
// The program of the paper's experiments, from outside: each writes its files, the same for any number of threads.
#include "tests/support/program.hpp"

#include <map>
#include <set>

namespace maxlogdet::test {
namespace {

class Simulate : public Program {
 protected:
  Simulate() : Program("maxlogdet_simulate", MAXLOGDET_SIMULATE) {}

  // The cells of a CSV file, the header first, without times: columns whose names begin with ms_ or us.
  std::vector<std::vector<std::string>> csv(const std::string& file) const {
    std::istringstream lines(text_of(path(file)));
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream cells(line);
      rows.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    const std::vector<std::string> header = rows.at(0);
    for (auto& row : rows) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (header[i].rfind("ms_", 0) == 0 || header[i].rfind("us", 0) == 0) row[i].clear();
      }
    }
    return rows;
  }

  // Runs an experiment with one thread and with two, and returns what it writes.
  std::vector<std::vector<std::string>> rows_of(const std::string& experiment, const std::string& arguments,
                                                const std::string& environment = "") const {
    const std::string command = experiment + ' ' + arguments;
    const Outcome outcome = run(command + " --threads 1 --output one", environment);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(run(command + " --threads 2 --output two", environment).exit_code, 0);
    const auto rows = csv("one/" + experiment + ".csv");
    EXPECT_EQ(csv("two/" + experiment + ".csv"), rows);
    EXPECT_FALSE(nlohmann::json::parse(text_of(path("one/" + experiment + ".json"))).at("table").empty());
    EXPECT_NE(text_of(path("one/" + experiment + ".md")), "");
    return rows;
  }
};

std::set<std::string> column(const std::vector<std::vector<std::string>>& rows, std::size_t i) {
  std::set<std::string> values;
  for (std::size_t row = 1; row < rows.size(); ++row) values.insert(rows[row].at(i));
  return values;
}

TEST_F(Simulate, metrics_compares_every_metric_with_every_block) {
  const auto rows = rows_of("metrics", "--points 40 --sizes 15,30 --runs 4");
  EXPECT_EQ(rows.size(), 1 + 2 * 2 * 3 * 7U);
  EXPECT_EQ(column(rows, 2), (std::set<std::string>{"map_bias", "measurement", "measurement_and_map"}));
  EXPECT_EQ(column(rows, 3), (std::set<std::string>{"max_log_det", "max_trace", "min_condition", "max_min_eigenvalue",
                                                    "random", "all", "all_weighted"}));
  EXPECT_EQ(csv("one/metrics_aligned.csv").at(0), rows.at(0));
  ASSERT_EQ(run("metrics --points 40 --sizes 15,30 --runs 4 --seed 1 --output three").exit_code, 0);
  EXPECT_NE(csv("three/metrics.csv"), rows);
  EXPECT_EQ(draw("one").exit_code, 0);
  EXPECT_NE(text_of(path("one/metrics_measurement.svg")).find("<svg"), std::string::npos);
}

TEST_F(Simulate, epsilon_covers_its_grid) {
  EXPECT_EQ(rows_of("epsilon", "--sizes 60,100 --runs 2").size(), 1 + 2 * 2 * 8 * 8U);
}

TEST_F(Simulate, euroc_and_budget_track_along_the_built_in_trajectory_without_recorded_ones) {
  const std::string small = "--max-matches 150 --runs 2 --seconds 4";
  const auto rows = rows_of("euroc", small, "MAXLOGDET_DATA=nowhere ");
  EXPECT_EQ(column(rows, 1), (std::set<std::string>{"quality", "bucket", "observability", "md", "quality_md", "inl",
                                                    "all", "all_weighted", "random"}));
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_LT(std::stod(rows[i].at(3)), 1) << "m: it does not lose track";
  const auto budgets = rows_of("budget", small + " --budgets 20,60", "MAXLOGDET_DATA=nowhere ");
  EXPECT_EQ(column(budgets, 2), (std::set<std::string>{"20", "60", "0"}));
}

TEST_F(Simulate, refuses_invalid_values) {
  for (const char* const arguments :
       {"", "everything", "metrics --runs 0", "metrics --threads -1", "metrics --sizes 4", "metrics --noise nan",
        "metrics --weightings heavy", "metrics --prior 1e-21", "metrics --map-bias inf", "epsilon --sizes 5",
        "epsilon --epsilons 2", "euroc --budget 1", "euroc --outliers 0.9", "euroc --trajectories nowhere",
        "euroc --selectors best"}) {
    expect_refused(run(arguments), "");
  }
}

}  // namespace
}  // namespace maxlogdet::test
