// SPDX-License-Identifier: MIT
// The program of the paper's experiments, from outside: each writes its tables, the same for any number of threads.
#include "tests/support/program.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

class Simulate : public Program {
 protected:
  Outcome simulate(const std::string& arguments) const {
    return run_script(MAXLOGDET_SIMULATE " " + arguments + " >out.txt 2>err.txt </dev/null");
  }

  // Runs an experiment on one thread and on two, and returns how many lines its table has.
  long lines_of(const std::string& arguments, const std::string& table, bool has_times = false) const {
    const Outcome outcome = simulate(arguments + " --threads 1 --output one");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(simulate(arguments + " --threads 2 --output two").exit_code, 0);
    const std::string text = text_of(path("one/" + table + ".csv"));
    if (!has_times) {
      EXPECT_EQ(text_of(path("two/" + table + ".csv")), text);
    }
    return std::count(text.begin(), text.end(), '\n');
  }
};

TEST_F(Simulate, metrics_and_epsilon_cover_their_grids) {
  EXPECT_EQ(lines_of("metrics --sizes 15,30,200 --runs 3", "metrics"), 1 + 2 * 3 * 6);
  const std::string means = text_of(path("one/metrics_means.csv"));
  EXPECT_EQ(std::count(means.begin(), means.end(), '\n'), 1 + 6 * 2 * 2);
  EXPECT_EQ(simulate("metrics --sizes 15,30,200 --runs 3 --seed 1 --output one").exit_code, 0);
  EXPECT_NE(text_of(path("one/metrics_means.csv")), means);
  EXPECT_EQ(lines_of("epsilon --sizes 60,1000 --runs 1", "epsilon", true), 1 + 2 * 8);
}

TEST_F(Simulate, trackers_follow_a_trajectory) {
  Lines circle;
  for (int i = 0; i < 90; ++i) {
    const double t = 0.05 * i;
    circle.push_back(std::to_string(t) + ' ' + std::to_string(std::cos(t)) + ' ' + std::to_string(std::sin(t)) +
                     " 0 0 0 0 1");
  }
  for (const char* const name : {"MH_05_difficult", "V1_01_easy"}) write(std::string("flown/") + name + ".txt", circle);
  const std::string few = " --runs 1 --seconds 2 --trajectories flown";
  EXPECT_EQ(lines_of("euroc" + few, "euroc_sequences"), 1 + 2 * 8);
  EXPECT_EQ(lines_of("euroc" + few + " --sequences V1_01_easy", "euroc_differences"), 1 + 2 * 7 * 3);
  EXPECT_EQ(lines_of("budget" + few, "budget"), 1 + 13 * 3);
  EXPECT_EQ(lines_of("time" + few, "time", true), 1 + 8);
}

}  // namespace
}  // namespace maxlogdet::test
