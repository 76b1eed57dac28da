// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/report.hpp"
#include "sim/names.hpp"

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace stereo_odometry {

constexpr const char* active_name = "active";  ///< the contestant that matches in the order of information

/// The command line of the program.
struct Arguments {
  Arguments() { selectors.emplace_back(active_name); }

  std::string dataset;
  std::string output;
  std::vector<std::string> selectors = maxlogdet::sim::names_of(maxlogdet::sim::selector_kinds);
  std::vector<std::size_t> budgets = {100};
  std::vector<double> targets;
  std::size_t runs = 10;
  std::size_t frames = 0;
  int features = 2000;
  int threads = 1;
  std::size_t overlays = 10;
  std::uint64_t seed = 0;
  std::string strategy = "lazy_greedy";
  std::string weighting = "measurement_and_map";
  std::string weights = "measurement_and_map";
  std::string residuals = "stereo";
  std::string noise = "motion";
  bool writes_residuals = false;
  TrackerOptions options;

  void add_to(CLI::App& program);

  /// Completes the arguments after parsing. Throws InputError if options repeat a value or have no effect.
  void finish(const CLI::App& program);

 private:
  void add_data(CLI::App& program);
  void add_contestants(CLI::App& program);
  void add_selection(CLI::App& program);
  void add_noise(CLI::App& program);
};

/// The contestants that the arguments ask for.
std::vector<Contestant> contestants_of(const Arguments& arguments);

}  // namespace stereo_odometry
