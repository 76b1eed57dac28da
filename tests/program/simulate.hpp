// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/trajectory.hpp"
#include "tests/support/program.hpp"

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

namespace maxlogdet::test {

// Small enough for an emulator.
constexpr char small_metrics[] = "metrics --points 40 --sizes 15,30 --runs 4 --output out";

class Simulate : public Program {
 protected:
  Simulate() : Program("maxlogdet_simulate", MAXLOGDET_SIMULATE) {}

  std::string contents(const std::string& file) const { return text_of(path(file)); }

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

  // The rows without times: columns whose names begin with ms_ or us.
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
    std::filesystem::create_directories(path("tum"));
    std::ofstream file(path("tum/" + name + ".txt"));
    file.precision(17);
    for (const sim::StampedPose& pose : sim::analytic_trajectory(5, 10).poses) {
      const Eigen::Quaterniond q(pose.T_wb.linear());
      const auto t = pose.T_wb.translation();
      file << pose.time << ' ' << t.transpose() << ' ' << q.coeffs().transpose() << '\n';
    }
  }
  std::string small_tracking(const std::string& experiment) const {
    return experiment + " --trajectories tum --max-matches 150 --runs 2 ";
  }
};

}  // namespace maxlogdet::test
